"""Public models with published bounds: functions that take (n, d) and return (n, m)."""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from models import BOREHOLE, borehole_y, ishigami_y

from kneecore import Input, Model, Output

FloatArray = np.ndarray


@dataclass(frozen=True, eq=False)
class Case:
    """One model: its bounds (d, 2), how many numbers it returns, and its function."""

    name: str
    run: Callable[[FloatArray], FloatArray]
    bounds: FloatArray
    n_outputs: int = 1

    @property
    def d(self) -> int:
        return len(self.bounds)

    def unit(self, u: FloatArray) -> FloatArray:
        """Return the outputs of points (n, d) of the unit cube."""
        low, high = self.bounds.T
        return self.run(low + u * (high - low))

    def model(self) -> Model:
        inputs = [Input(f"x_{k + 1}", lower=a, upper=b) for k, (a, b) in enumerate(self.bounds)]
        axis = tuple(range(self.n_outputs)) if self.n_outputs > 1 else None
        return Model(self.run, inputs, [Output("y", axis=axis)], batched=True, name=self.name)


def around(values: list[float], percent: float) -> FloatArray:
    centre = np.array(values)
    return np.stack([centre * (1 - percent / 100), centre * (1 + percent / 100)], axis=1)


def otl(x):
    """E. N. Ben-Ari, D. M. Steinberg (2007), Quality Engineering 19:327-338."""
    b1, b2, f, c1, c2, beta = x.T
    v = 12.0 * b2 / (b1 + b2)
    s = beta * (c2 + 9.0)
    return ((v + 0.74) * s / (s + f) + 11.35 * f / (s + f) + 0.74 * f * s / ((s + f) * c1))[:, None]


def piston(x):
    """R. S. Kenett, S. Zacks (1998), Modern Industrial Statistics: cycle time, s."""
    m, area, v0, k, p0, ta, t0 = x.T
    a = p0 * area + 19.62 * m - k * v0 / area
    v = area / (2.0 * k) * (np.sqrt(a**2 + 4.0 * k * p0 * v0 / t0 * ta) - a)
    return (2.0 * np.pi * np.sqrt(m / (k + area**2 * p0 * v0 / t0 * ta / v**2)))[:, None]


def wing(x):
    """A. I. J. Forrester, A. Sobester, A. J. Keane (2008): weight of a wing, lb."""
    sw, wfw, a, sweep, q, taper, tc, nz, wdg, wp = x.T
    c = np.cos(np.radians(sweep))
    y = 0.036 * sw**0.758 * wfw**0.0035 * (a / c**2) ** 0.6 * q**0.006 * taper**0.04
    return (y * (100.0 * tc / c) ** -0.3 * (nz * wdg) ** 0.49 + sw * wp)[:, None]


def flood(x):
    """B. Iooss, P. Lemaitre (2015): height of a river over its dyke, m."""
    q, ks, zv, zm, hd, cb, length, width = x.T
    h = (q / (width * ks * np.sqrt((zm - zv) / length))) ** 0.6
    return (zv + h - hd - cb)[:, None]


def robot_arm(x):
    """J. An, A. Owen (2001), J. Complexity 17:588-608: how far a four-piece arm reaches."""
    turns = np.cumsum(x[:, :4], axis=1)
    along = x[:, 4:] * np.cos(turns), x[:, 4:] * np.sin(turns)
    return np.hypot(along[0].sum(axis=1), along[1].sum(axis=1))[:, None]


def band_pass(x):
    """Two coupled series-resonant circuits: gain over 40 frequencies, dB."""
    r, l1, c1, l2, c2, coupling, load = (v[:, None] for v in x.T)
    w = 2.0 * np.pi * np.geomspace(2e3, 12e3, 40)
    z1 = r + 1j * (w * l1 - 1.0 / (w * c1))
    z2 = load + 1j * (w * l2 - 1.0 / (w * c2))
    m = 1j * w * coupling * np.sqrt(l1 * l2)
    return 20.0 * np.log10(np.abs(load * m / (z1 * z2 - m**2)))


def four_bar(x):
    """A crank-rocker: height of its coupler point at eight turns of the crank, mm."""
    a, b, c, g, along, across = (v[:, None] for v in x.T)
    turn = np.radians(np.arange(0.0, 360.0, 45.0))
    px, py = a * np.cos(turn), a * np.sin(turn)
    dx, dy = g - px, -py
    s = np.hypot(dx, dy)
    angle = np.arctan2(dy, dx) + np.arccos((b**2 + s**2 - c**2) / (2.0 * b * s))
    return py + along * np.sin(angle) + across * np.cos(angle)


NODES = np.array([[720, 360], [720, 0], [360, 360], [360, 0], [0, 360], [0, 0]], dtype=float)
BARS = np.array([[4, 2], [2, 0], [5, 3], [3, 1], [3, 2], [1, 0], [4, 3], [5, 2], [2, 1], [3, 0]])


def ten_bar(x):
    """The ten-bar truss (areas, in^2; load, kip): all eight displacements, in."""
    along = NODES[BARS[:, 1]] - NODES[BARS[:, 0]]
    length = np.linalg.norm(along, axis=1)
    rows = np.zeros((10, 12))
    for k, (i, j) in enumerate(BARS):
        unit = along[k] / length[k]
        rows[k, 2 * i : 2 * i + 2], rows[k, 2 * j : 2 * j + 2] = -unit, unit
    rows = rows[:, :8]
    stiff = np.einsum("nk,ki,kj->nij", 1e4 * x[:, :10] / length, rows, rows)
    force = np.zeros((len(x), 8))
    force[:, [3, 7]] = -x[:, 10:]
    return np.linalg.solve(stiff, force[..., None])[..., 0]


def compliant_arm(x):
    """Two links with springs in their joints: tip, mm, under six loads, outputs interleaved."""
    l1, l2, k1, k2, a1, a2 = (v[:, None] for v in x.T)
    load = np.linspace(1.0, 6.0, 6)
    q1 = np.full((len(x), 6), a1)
    q2 = np.broadcast_to(a2, q1.shape)
    for _ in range(60):
        both = q1 + q2
        arm = l2 * np.cos(both)
        q1, q2 = (
            a1 - load * (l1 * np.cos(q1) + arm) / k1,
            a2 - load * arm / k2,
        )
    tip = [l1 * np.cos(q1) + l2 * np.cos(q1 + q2), l1 * np.sin(q1) + l2 * np.sin(q1 + q2)]
    return np.stack(tip, axis=2).reshape(len(x), -1)


def sobol_g(x):
    """Sobol's g function with the weights 0, 1, 4.5, 9, 99, 99."""
    a = np.array([0.0, 1.0, 4.5, 9.0, 99.0, 99.0])
    return ((np.abs(4.0 * x - 2.0) + a) / (1.0 + a)).prod(axis=1)[:, None]


def branin(x):
    one, two = x.T
    bowl = (two - 5.1 / (4 * np.pi**2) * one**2 + 5.0 / np.pi * one - 6.0) ** 2
    return (bowl + 10.0 * (1.0 - 1.0 / (8 * np.pi)) * np.cos(one) + 10.0)[:, None]


H_A = np.array(
    [[10, 3, 17, 3.5, 1.7, 8], [0.05, 10, 17, 0.1, 8, 14],
     [3, 3.5, 1.7, 10, 17, 8], [17, 8, 0.05, 10, 0.1, 14]]
)  # fmt: skip
H_P = 1e-4 * np.array(
    [[1312, 1696, 5569, 124, 8283, 5886], [2329, 4135, 8307, 3736, 1004, 9991],
     [2348, 1451, 3522, 2883, 3047, 6650], [4047, 8828, 8732, 5743, 1091, 381]]
)  # fmt: skip


def hartmann(x):
    near = np.exp(-(H_A * (x[:, None] - H_P) ** 2).sum(axis=2))
    return -(near @ np.array([1.0, 1.2, 3.0, 3.2]))[:, None]


def friedman(x):
    a, b, c, d, e = x.T
    return (10 * np.sin(np.pi * a * b) + 20 * (c - 0.5) ** 2 + 10 * d + 5 * e)[:, None]


def quarter_car(x):
    """Body acceleration of a quarter car by road amplitude at 30 frequencies, dB."""
    ms, mu, ks, kt, cs, ct = (v[:, None] for v in x.T)
    w = 2.0 * np.pi * np.geomspace(0.5, 20.0, 30)
    spring, tyre = ks + 1j * w * cs, kt + 1j * w * ct
    det = (spring - ms * w**2) * (spring + tyre - mu * w**2) - spring**2
    return 20.0 * np.log10(w**2 * np.abs(spring * tyre / det))


def welch(x):
    """W. J. Welch et al. (1992), Technometrics 34:15-25."""
    v = [None, *x.T]
    y = 5 * v[12] / (1 + v[1]) + 5 * (v[4] - v[20]) ** 2 + v[5] + 40 * v[19] ** 3 - 5 * v[19]
    y = y + 0.05 * v[2] + 0.08 * v[3] - 0.03 * v[6] + 0.03 * v[7] - 0.09 * v[9] - 0.01 * v[10]
    y = y - 0.07 * v[11] + 0.25 * v[13] ** 2 - 0.04 * v[14] + 0.06 * v[15] - 0.01 * v[17]
    return (y - 0.03 * v[18])[:, None]


def curved(x):
    """H. Dette, A. Pepelyshev (2010), Technometrics 52:421-429: highly curved in some inputs."""
    a, b, c = x[:, 0], x[:, 1], x[:, 2]
    y = 4 * (a - 2 + 8 * b - 8 * b**2) ** 2 + (3 - 4 * b) ** 2
    y = y + 16 * np.sqrt(c + 1) * (2 * c - 1) ** 2
    sums = np.cumsum(x[:, 2:], axis=1)[:, 1:]
    return (y + (np.arange(4, 9) * np.log1p(sums)).sum(axis=1))[:, None]


def spill(x):
    """N. Bliznyuk et al. (2008), J. Comput. Graph. Stat. 17:270-294: two spills of a pollutant.

    Scaled concentration at five places and six times; the second spill is at about 30.
    """
    mass, diffusion, place, time = (v[:, None, None] for v in x.T)
    s, t = np.arange(0.5, 2.6, 0.5)[:, None], np.arange(10.0, 61.0, 10.0)
    first = mass / np.sqrt(diffusion * t) * np.exp(-(s**2) / (4 * diffusion * t))
    since = np.where(t > time, t - time, np.inf)
    second = (
        mass / np.sqrt(diffusion * since) * np.exp(-((s - place) ** 2) / (4 * diffusion * since))
    )
    return (first + second).reshape(len(x), -1)


def morris(x):
    """M. D. Morris (1991), Technometrics 33:161-174; (-1)^i and (-1)^(i+j) for its draws."""
    w = 2.0 * (x - 0.5)
    w[:, [2, 4, 6]] = 2.0 * (1.1 * x[:, [2, 4, 6]] / (x[:, [2, 4, 6]] + 0.1) - 0.5)
    sign = (-1.0) ** np.arange(1, 21)
    one, two = sign.copy(), np.outer(sign, sign)
    one[:10], two[:6, :6] = 20.0, -15.0
    y = w @ one + np.einsum("ni,ij,nj->n", w, np.triu(two, 1), w)
    threes = combinations(range(5), 3)
    y = y - 10.0 * sum(w[:, i] * w[:, j] * w[:, k] for i, j, k in threes)
    return (y + 5.0 * w[:, :4].prod(axis=1))[:, None]


def waves(x):
    """R. B. Gramacy, H. K. H. Lee (2009), Technometrics 51:130-145; two inputs have no effect."""
    y = np.exp(np.sin((0.9 * (x[:, 0] + 0.48)) ** 10))
    return (y + x[:, 1] * x[:, 2] + x[:, 3])[:, None]


def box(*rows: tuple[float, float]) -> FloatArray:
    return np.array(rows, dtype=float)


CASES = [
    Case("Ishigami", ishigami_y, box(*[(-np.pi, np.pi)] * 3)),
    Case("Borehole", lambda x: borehole_y(x.T)[:, None], box(*[b[:2] for b in BOREHOLE.values()])),
    Case("OTL circuit", otl,
         box((50, 150), (25, 70), (0.5, 3), (1.2, 2.5), (0.25, 1.2), (50, 300))),
    Case("Piston", piston, box((30, 60), (0.005, 0.02), (0.002, 0.01), (1000, 5000),
                               (90_000, 110_000), (290, 296), (340, 360))),
    Case("Wing weight", wing, box((150, 200), (220, 300), (6, 10), (-10, 10), (16, 45), (0.5, 1),
                                  (0.08, 0.18), (2.5, 6), (1700, 2500), (0.025, 0.08))),
    Case("Flood", flood, box((500, 3000), (15, 50), (49, 51), (54, 55), (7, 9), (55, 56),
                             (4990, 5010), (295, 305))),
    Case("RobotArm", robot_arm, box(*[(0, 2 * np.pi)] * 4, *[(0, 1)] * 4)),
    Case("band-pass", band_pass,
         around([20.0, 10e-3, 0.1e-6, 10e-3, 0.1e-6, 0.25, 20.0], 5), 40),
    Case("four-bar", four_bar, around([30.0, 80.0, 70.0, 90.0, 40.0, 25.0], 3), 8),
    Case("ten-bar truss", ten_bar, around([8.0] * 10 + [100.0] * 2, 10), 8),
    Case("compliant arm", compliant_arm,
         around([300.0, 250.0, 9e3, 7e3, 0.6, 0.8], 10), 12),
    Case("Sobol g", sobol_g, box(*[(0, 1)] * 6)),
    Case("Branin", branin, box((-5, 10), (0, 15))),
    Case("Hartmann-6", hartmann, box(*[(0, 1)] * 6)),
    Case("Friedman", friedman, box(*[(0, 1)] * 5)),
    Case("quarter car", quarter_car,
         around([300.0, 40.0, 18e3, 180e3, 1200.0, 50.0], 15), 30),
    Case("Welch", welch, box(*[(-0.5, 0.5)] * 20)),
    Case("Dette-Pepelyshev", curved, box(*[(0, 1)] * 8)),
    Case("pollutant spill", spill, box((7, 13), (0.02, 0.12), (0.01, 3), (30.01, 30.295)), 30),
    Case("Morris", morris, box(*[(0, 1)] * 20)),
    Case("Gramacy-Lee", waves, box(*[(0, 1)] * 6)),
]  # fmt: skip
