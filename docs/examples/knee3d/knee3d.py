"""A right knee at 30 degrees of flexion in MuJoCo: two condyles, two plateaus, four ligaments.

Millimetres for people, metres for MuJoCo. x is anterior, y proximal, z lateral; both bones' frames
coincide in full extension, with their origin between the epicondyles.
"""

import mujoco
import numpy as np

from kneecore import Shape

FLEXION = 30.0
"""Held, deg; the tibia is free in the other five ways."""
MOMENTS = (-2.0, -1.0, -0.5, 0.5, 1.0, 2.0)
"""About the tibia's axis, internal > 0, N m."""
DRAWERS = (-100.0, -50.0, 50.0, 100.0)
"""Along the tibia's x, anterior > 0, N."""
STRETCH = 0.02
"""Of every ligament in the reference pose."""
STEP = 0.002
"""Of time, s; 4 ms would be unstable."""
RADII = {"medial": (-22.0, 22.0), "lateral": (22.0, 21.0)}
"""z and radius of the condyles' posterior spheres, mm."""

# Bundles: ligament, place from its attachments' middle on femur and tibia (mm), stiffness (N per
# unit of strain).
BUNDLES = {
    "acl_am": ("acl", (1.0, 2.5, -1.5), (1.0, 0.0, -3.0), 4920.0),
    "acl_pl": ("acl", (-1.0, -2.5, 1.5), (-1.0, 0.0, 3.0), 4920.0),
    "pcl_al": ("pcl", (1.0, 2.0, 1.0), (1.5, 1.5, 3.0), 4500.0),
    "pcl_pm": ("pcl", (-1.0, -2.0, -1.0), (-1.5, -1.5, -3.0), 1500.0),
    "mcl": ("mcl", (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 3000.0),
    "lcl": ("lcl", (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 2400.0),
}
LIGAMENTS = ("acl", "pcl", "mcl", "lcl")

WORLD = """
<mujoco>
  <compiler angle="degree"/>
  <option gravity="0 0 0" timestep="{step}" integrator="implicitfast">
    <flag autoreset="disable"/>
  </option>
  <default>
    <geom condim="1" solref="-2e5 -400" solimp="0.9 0.9 0.001"/>
    <joint type="hinge" damping="0.2"/>
    <default class="slide"><joint type="slide" damping="100"/></default>
  </default>
  <worldbody>
    {condyles} {femur_sites}
    <body name="tibia" euler="0 0 -{flexion}">
      <inertial mass="1" pos="0 0 0" diaginertia="0.003 0.003 0.003"/>
      <joint name="ap" class="slide" axis="1 0 0"/>
      <joint name="axial" class="slide" axis="0 1 0"/>
      <joint name="ml" class="slide" axis="0 0 1"/>
      <joint name="abduction" axis="1 0 0"/>
      <joint name="rotation" axis="0 1 0"/>
      {plateaus} {tibia_sites}
    </body>
  </worldbody>
  <tendon>{bundles}</tendon>
</mujoco>
"""


def attachments(x):
    """Return {bundle: (place on the femur, place on the tibia)}, m, of 24 coordinates in mm."""
    middle = 1e-3 * np.reshape(x, (len(LIGAMENTS), 2, 3))
    return {
        name: tuple(middle[LIGAMENTS.index(ligament)] + 1e-3 * np.array([femur, tibia]))
        for name, (ligament, femur, tibia, _) in BUNDLES.items()
    }


def rotated(flexion):
    """Return the matrix from the tibia's to the femur's frame in the reference pose."""
    c, s = np.cos(np.radians(flexion)), np.sin(np.radians(flexion))
    return np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])


def springs(x):
    """Return {bundle: (length without tension, m, coefficient, N/m^2)}: the force is k e^2."""
    found = {}
    for name, (femur, tibia) in attachments(x).items():
        rest = np.linalg.norm(rotated(FLEXION) @ tibia - femur) / (1.0 + STRETCH)
        # Up to 6 % of strain Blankevoort's force is stiffness * strain^2 / (2 * 0.06).
        found[name] = rest, BUNDLES[name][3] / (0.12 * rest**2)
    return found


def compiled(x):
    """Return MuJoCo's model of one knee."""
    places, law = attachments(x), springs(x)

    def sites(end):
        return " ".join(
            '<site name="{}{}" pos="{} {} {}"/>'.format(n, end, *p[end]) for n, p in places.items()
        )

    return mujoco.MjModel.from_xml_string(
        WORLD.format(
            step=STEP,
            flexion=FLEXION,
            femur_sites=sites(0),
            tibia_sites=sites(1),
            condyles=" ".join(
                f'<geom type="sphere" size="{1e-3 * r}" pos="0 0 {1e-3 * z}"/>'
                for z, r in RADII.values()
            ),
            plateaus=" ".join(
                f'<geom type="box" size=".03 .01 .02" pos="0 {-1e-3 * r - 0.01} {1e-3 * z}"/>'
                for z, r in RADII.values()
            ),
            bundles=" ".join(
                f'<spatial name="{n}" springlength="0 {rest}" stiffness="0 {k} 0">'
                f'<site site="{n}0"/><site site="{n}1"/></spatial>'
                for n, (rest, k) in law.items()
            ),
        )
    )


def settled(model, data, longest=2000, still=1e-4):
    """Go on in time until nothing moves any more; NaN where it does not come to rest."""
    for _ in range(0, longest, 50):
        mujoco.mj_step(model, data, nstep=50)
        fastest = np.abs(data.qvel).max()
        if not fastest >= still:  # at rest, or NaN: without `autoreset` what is unstable stays so
            return data.qpos + 0.0 * fastest
    return np.full(model.nq, np.nan)


def poses(x):
    """Return the pose at rest, of m and rad: {(coordinate, load): (5,)}, each from its lesser."""
    model = compiled(x)
    data = mujoco.MjData(model)
    neutral = settled(model, data)
    found = {}
    for joint, loads in (("rotation", MOMENTS), ("ap", DRAWERS)):
        at = model.joint(joint).dofadr[0]
        for way in (-1.0, 1.0):
            mujoco.mj_resetData(model, data)
            data.qpos[:] = neutral
            for load in sorted((v for v in loads if v * way > 0.0), key=abs):
                data.qfrc_applied[at] = load
                found[joint, load] = settled(model, data)
    return found


def run(x):
    """Return internal rotation (deg) at MOMENTS and anterior place (mm) at DRAWERS."""
    at = poses(x)
    return [
        *(np.degrees(at["rotation", moment][4]) for moment in MOMENTS),
        *(1e3 * at["ap", force][0] for force in DRAWERS),
    ]


def draw(x):
    """Return the knee from its side, as it is built: mm, in the femur's frame."""
    turn = np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)
    z, radius = RADII["lateral"]
    down = rotated(FLEXION)
    plateau = np.array([[-30.0, -radius, z], [30.0, -radius, z]]) @ down.T
    bundles = [
        Shape(
            name=name,
            points=1e3 * np.array([femur, down @ tibia])[:, :2],
            kind="link",
            label=name if name in ("mcl", "lcl") else "",
        )
        for name, (femur, tibia) in attachments(x).items()
    ]
    circle = radius * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    return [
        Shape(name="condyle", points=circle, kind="closed"),
        Shape(name="plateau", points=plateau[:, :2]),
        *bundles,
    ]
