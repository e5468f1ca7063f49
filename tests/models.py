"""Models that nobody here wrote, with their bounds as published, and a few made for tests."""

import numpy as np

from kneecore import Input, Model, Output, Shape

# T. Ishigami, T. Homma (1990): An importance quantification technique in uncertainty analysis for
# computer models. Proc. First Int. Symp. Uncertainty Modeling and Analysis, 398-403. With a = 7 and
# b = 0.1, as most use it; all inputs from -pi to pi.
A, B = 7.0, 0.1


def ishigami_y(x):
    one, two, three = x.T
    return (np.sin(one) + A * np.sin(two) ** 2 + B * three**4 * np.sin(one))[:, None]


def ishigami_gradient(x):
    """Return the derivatives, shape (n, 1, 3)."""
    one, two, three = x.T
    rows = [
        np.cos(one) * (1.0 + B * three**4),
        2.0 * A * np.sin(two) * np.cos(two),
        4.0 * B * three**3 * np.sin(one),
    ]
    return np.stack(rows, axis=1)[:, None, :]


def ishigami(**options):
    inputs = [Input(f"x_{k}", lower=-np.pi, upper=np.pi, unit="rad") for k in (1, 2, 3)]
    return Model(
        ishigami_y, inputs, [Output("y")], **{"batched": True, "name": "Ishigami"} | options
    )


# W. V. Harper, S. K. Gupta (1983): Sensitivity/uncertainty analysis of a borehole scenario
# comparing Latin hypercube sampling and deterministic sensitivity approaches. BMI/ONWI-516,
# Battelle Memorial Institute. Bounds as in M. D. Morris, T. J. Mitchell, D. Ylvisaker (1993):
# Bayesian design and analysis of computer experiments. Technometrics 35:243-255.
BOREHOLE = {
    "r_w": (0.05, 0.15, "m"),  # radius of the borehole
    "r": (100.0, 50_000.0, "m"),  # radius of influence
    "T_u": (63_070.0, 115_600.0, "m^2/yr"),  # transmissivity of the upper aquifer
    "H_u": (990.0, 1110.0, "m"),  # its potentiometric head
    "T_l": (63.1, 116.0, "m^2/yr"),  # the same of the lower aquifer
    "H_l": (700.0, 820.0, "m"),
    "L": (1120.0, 1680.0, "m"),  # length of the borehole
    "K_w": (9855.0, 12_045.0, "m/yr"),  # its hydraulic conductivity
}


def borehole_y(x):
    """Return the flow through one borehole, m^3/yr."""
    r_w, r, t_u, h_u, t_l, h_l, length, k_w = x
    log = np.log(r / r_w)
    return 2.0 * np.pi * t_u * (h_u - h_l) / (
        log * (1.0 + 2.0 * length * t_u / (log * r_w**2 * k_w) + t_u / t_l)
    )  # fmt: skip


def borehole():
    """One point at a time, as a function is mostly written."""
    inputs = [Input(n, lower=a, upper=b, unit=u) for n, (a, b, u) in BOREHOLE.items()]
    return Model(borehole_y, inputs, [Output("flow", unit="m^3/yr")], name="Borehole")


CRANK = np.radians([30.0, 60.0, 90.0, 120.0, 150.0])


def joints_of(x):
    """Return crank pin and coupler pin of a slider-crank, shape (2, 5, 2), mm."""
    crank, rod, offset = x
    pin = crank * np.stack([np.cos(CRANK), np.sin(CRANK)], axis=1)
    slider = pin[:, 0] + np.sqrt(rod**2 - (pin[:, 1] - offset) ** 2)
    return np.stack([pin, np.stack([slider, np.full(5, offset)], axis=1)])


def slider_crank_y(x):
    """Return the slider's place at five turns of the crank, mm, and its stroke's ratio to it."""
    crank, rod, offset = x
    out, back = np.sqrt((rod + crank) ** 2 - offset**2), np.sqrt((rod - crank) ** 2 - offset**2)
    return [*joints_of(x)[1, :, 0], (out - back) / (2.0 * crank)]


def slider_crank():
    """Two outputs with units and scales, a curve and a number, and a picture."""

    def draw(x):
        pin, slider = joints_of(x)[:, 2]
        return [
            Shape(name="crank", points=np.array([[0.0, 0.0], pin]), label="crank"),
            Shape(name="rod", points=np.array([pin, slider]), kind="link", label="rod"),
            Shape(name="slider", points=slider + 8.0 * SQUARE, kind="closed"),
        ]

    inputs = [
        Input("crank", nominal=50.0, tolerance_percent=2.0, unit="mm"),
        Input("rod", nominal=120.0, half_range=1.5, unit="mm"),
        Input("offset", nominal=0.0, lower=-4.0, upper=4.0, unit="mm"),
    ]
    outputs = [
        Output("place", unit="mm", axis=(30, 60, 90, 120, 150), axis_name="crank angle",
               axis_unit="deg", scale=1.0),
        Output("stroke ratio", scale=0.01),
    ]  # fmt: skip
    return Model(slider_crank_y, inputs, outputs, draw=draw, name="slider-crank")


SQUARE = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


def two_units():
    """A curve and a number of different units, each with the difference that counts as 1."""
    inputs = [
        Input("k", nominal=100.0, tolerance_percent=10.0, unit="N/mm"),
        Input("m", nominal=2.0, half_range=0.1, unit="kg"),
    ]
    outputs = [
        Output("stretch", unit="mm", axis=(1, 2, 5), axis_name="load", axis_unit="N", scale=0.01),
        Output("frequency", unit="Hz", scale=2.0),
    ]

    def run(x):
        k, m = x
        return [*(np.array([1.0, 2.0, 5.0]) / k), np.sqrt(1000.0 * k / m) / (2.0 * np.pi)]

    return Model(run, inputs, outputs, name="a mass on a spring")
