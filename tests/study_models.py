"""Published test functions as models, with what is known of them."""

import itertools

import numpy as np

from kneecore import Input, Model, Output

# Ishigami & Homma 1990; the variances are those of Saltelli et al. 2000.
A, B = 7.0, 0.1


def ishigami():
    """Return sin x_1 + a sin^2 x_2 + b x_3^4 sin x_1 over (-pi, pi)^3."""

    def run(x):
        one, two, three = x.T
        return (np.sin(one) + A * np.sin(two) ** 2 + B * three**4 * np.sin(one))[:, None]

    inputs = [Input(f"x_{k}", lower=-np.pi, upper=np.pi) for k in (1, 2, 3)]
    return Model(run, inputs, [Output("y")], batched=True, name="Ishigami")


def _variances():
    one = 0.5 * (1.0 + B * np.pi**4 / 5.0) ** 2
    two = A**2 / 8.0
    one_three = 8.0 * B**2 * np.pi**8 / 225.0
    return one, two, one_three


ISHIGAMI_VARIANCE = sum(_variances())
ISHIGAMI_FIRST = np.array([_variances()[0], _variances()[1], 0.0]) / ISHIGAMI_VARIANCE
ISHIGAMI_TOTAL = (
    np.array([_variances()[0] + _variances()[2], _variances()[1], _variances()[2]])
    / ISHIGAMI_VARIANCE
)
ISHIGAMI_MEAN = A / 2.0
ISHIGAMI_MOST = 1.0 + A + B * np.pi**4  # at pi/2, pi/2, pi
ISHIGAMI_LEAST = -1.0 - B * np.pi**4  # at -pi/2, 0, pi

_BOREHOLE = (
    ("r_w", 0.05, 0.15, "m"),
    ("r", 100.0, 50_000.0, "m"),
    ("T_u", 63_070.0, 115_600.0, "m2/yr"),
    ("H_u", 990.0, 1110.0, "m"),
    ("T_l", 63.1, 116.0, "m2/yr"),
    ("H_l", 700.0, 820.0, "m"),
    ("L", 1120.0, 1680.0, "m"),
    ("K_w", 9855.0, 12_045.0, "m/yr"),
)


def borehole():
    """Return the flow of water through a borehole (Harper & Gupta 1983)."""

    def run(x):
        r_w, r, t_u, h_u, t_l, h_l, length, k_w = x.T
        apart = np.log(r / r_w)
        below = apart * (1.0 + 2.0 * length * t_u / (apart * r_w**2 * k_w) + t_u / t_l)
        return (2.0 * np.pi * t_u * (h_u - h_l) / below)[:, None]

    inputs = [Input(n, lower=low, upper=high, unit=unit) for n, low, high, unit in _BOREHOLE]
    return Model(run, inputs, [Output("flow", unit="m3/yr")], batched=True, name="Borehole")


def corner_values(model):
    """Return the outputs in all corners of a model's box: the extremes, where it is monotone."""
    corners = np.array(list(itertools.product((0.0, 1.0), repeat=model.n_free)))
    return model.evaluate(model.from_free_unit(corners))


class Filter(Model):
    """A band-pass with a curve and a number of other units, groups, and a quantity observed."""

    watched = 2

    def __init__(self):
        self.frequency = np.array([5e3, 2e4, 4.1e4, 8e4])
        super().__init__(
            self._response,
            [
                Input(
                    "L",
                    nominal=1.5e-3,
                    tolerance_percent=5,
                    unit="H",
                    shown_unit="mH",
                    shown_scale=1e-3,
                ),
                Input("C", nominal=1e-8, tolerance_percent=5, unit="F"),
                Input("R", nominal=100.0, tolerance_percent=2, unit="ohm"),
                Input("T", nominal=20.0, half_range=0.0, unit="degC"),
            ],
            [
                Output(
                    "gain",
                    unit="dB",
                    axis=tuple(self.frequency),
                    axis_name="frequency",
                    axis_unit="Hz",
                    scale=3.0,
                ),
                Output("quality", scale=0.5),
            ],
            batched=True,
            name="band-pass",
        )

    @property
    def groups(self):
        """Store energy, or spend it."""
        return {"L": "storage", "C": "storage", "R": "loss"}

    def _response(self, x):
        inductance, capacity, resistance, _ = x.T[:, :, None]
        omega = 2.0 * np.pi * self.frequency
        reactance = omega * inductance - 1.0 / (omega * capacity)
        gain = 20.0 * np.log10(resistance / np.hypot(resistance, reactance))
        return np.hstack([gain, np.sqrt(inductance / capacity) / resistance])


LEVERS = np.array([8.0, 4.0, 2.0, 1.0, 0.01])


class Levers(Model):
    """A sum of inputs with known gradient; the first two are measured at once."""

    def __init__(self, **options):
        super().__init__(
            lambda x: x @ LEVERS[:, None],
            [
                Input("a", nominal=10.0, half_range=2.0, unit="mm", measurement="ends"),
                Input("b", nominal=-3.0, half_range=2.0, unit="mm", measurement="ends"),
                Input("c", nominal=50.0, tolerance_percent=10.0, unit="N", measurement="force"),
                Input("d", lower=-4.0, upper=4.0, unit="deg", measurement="slope"),
                Input("e", nominal=1.0, half_range=1.0, unit="deg", measurement="offset"),
            ],
            [Output("sum", unit="mm")],
            batched=True,
            gradient=lambda x: np.broadcast_to(LEVERS, (len(x), 1, 5)),
            name="levers",
            **options,
        )
