"""The 2D dynamic knee: forces, load-free pose, motion, equilibria. It knows no optimiser.

The mechanics are those of Machado et al. 2010 (Nonlinear Dyn. 60:459-478) as Ciszkiewicz & Dumas
2024 (Front. Mech. Eng. 10:1392616) use them; the baseline's values are a reconstruction.

Frames
    The femur is fixed. Its frame has its origin at the baseline's centre of the condylar circle, x
    anterior, y proximal in the standing, extended leg. The tibia's frame has its origin at the
    baseline's reference point of the plateau line and is parallel to the femur's at full extension.
    phi is the tibia's counter-clockwise turn; the flexion angle is theta = -phi, negative when
    over-extended. A point a of the tibia stands at o + R(phi) a.
Ligaments
    With attachments p on the femur and a on the tibia, length l and rest length l0, the tension is
    k (l - l0)^2 for l > l0, else 0, along the line between the attachments.
Contact
    d is the distance of the circle's centre from the plateau line along its normal n, the
    indentation delta = radius - d. For delta > 0 the force K delta^1.5 acts on the tibia along -n
    through the circle's centre, K = (4/3) sqrt(radius) / (2 (1 - nu^2) / E): two equal bodies.
Other forces
    An external moment on the tibia, extension positive; damping of 1 N s/m on the mass centre's
    velocity and 1.5 N m s/rad on the turn. No gravity, friction, patella or muscle.
Load-free pose
    theta_0 = 54.79 deg. The baseline's circle touches its line 8.1 mm behind the plateau point. A
    perturbed knee keeps the angle and the tibia's origin, and the tibia then moves along its own
    plateau's normal until its own circle touches its own line. Rest lengths are the distances
    between the attachments in that pose (``recomputed``), or the baseline's (``fixed``).
Motion
    From rest in the load-free pose, semi-implicit Euler with 4 ms: velocities from the forces at
    the current pose and the old velocities, then the pose from the new velocities. Moments of 0.1,
    0.2, 0.4, 0.8, 2 and 5 N m start at 0, 7, 11, 14, 17 and 20 s; the end is at 23 s. A second run
    has the sign reversed. The response is read after each moment's last step.
Settled
    A load has settled if theta changed by less than 0.2 deg in its last 0.5 s. At 0.1 N m damping
    limits the turn to 0.07 rad/s, so that a very lax knee cannot come to rest within 7 s.
Equilibrium
    The other way to a response: the knee at rest under each load, by the potential that all forces
    but damping come from. Loads rise from the load-free pose, and each equilibrium is the one that
    the last one leads to; where none is left to lead to, the load is reported (``lost_at``) and the
    motion's response taken.
Status
    A run is wild if it turns non-finite or by 150 deg or more from theta_0, hot if it has more than
    5 mJ of kinetic energy at the end of a load. Such a run is repeated with the time step halved,
    up to three times: ``refined``, or ``failed``. It is accepted once it is neither; or hot, if it
    agrees with the run before it within 0.2 deg at every load, neither is wild, and its hot loads
    are settled: then the knee rings, not the integration. Wild twice in a row, it has dislocated.
"""
