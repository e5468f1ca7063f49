"""A Butterworth band-pass of third order between 50 ohm: three resonators in a ladder."""

import numpy as np

from kneecore import Input, Model, Output

FREQUENCY = np.geomspace(5e3, 20e3, 25)  # Hz
MIDDLE, WIDTH, RESISTANCE = 10e3, 4e3, 50.0  # Hz, Hz, ohm

# The low-pass prototype's element values are 1, 2, 1; each becomes a resonator at MIDDLE.
SERIES_L = RESISTANCE / (2.0 * np.pi * WIDTH)
SHUNT_C = 2.0 / (RESISTANCE * 2.0 * np.pi * WIDTH)
SERIES_C, SHUNT_L = (1.0 / ((2.0 * np.pi * MIDDLE) ** 2 * v) for v in (SERIES_L, SHUNT_C))
NOMINAL = {
    "L1": (SERIES_L, "H"), "C1": (SERIES_C, "F"),
    "L2": (SHUNT_L, "H"), "C2": (SHUNT_C, "F"),
    "L3": (SERIES_L, "H"), "C3": (SERIES_C, "F"),
}  # fmt: skip


def gain_db(x):
    """Return the load's share of the power that the source can give, dB: (n, 6) to (n, 25)."""
    l1, c1, l2, c2, l3, c3 = (v[:, None] for v in x.T)
    w = 2.0 * np.pi * FREQUENCY
    first, third = (1j * (w * v - 1.0 / (w * c)) for v, c in ((l1, c1), (l3, c3)))
    shunt = 1j * (w * c2 - 1.0 / (w * l2))  # an admittance
    # From the load back to the source: what must be put in for 1 V at the load.
    current = 1.0 / RESISTANCE
    voltage = 1.0 + third * current
    current = current + shunt * voltage
    voltage = voltage + (first + RESISTANCE) * current
    return 20.0 * np.log10(2.0 / np.abs(voltage))


def model(**options):
    """Return the filter with components of 5 %."""
    inputs = [
        Input(name, nominal=value, tolerance_percent=5, unit=unit)
        for name, (value, unit) in NOMINAL.items()
    ]
    gain = Output("gain", unit="dB", axis=FREQUENCY, axis_name="frequency", axis_unit="Hz")
    return Model(gain_db, inputs, [gain], batched=True, name="band-pass", **options)
