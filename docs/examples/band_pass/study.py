"""How different two band-passes of the same parts list can be: ``python study.py``."""

import numpy as np
from band_pass import FREQUENCY, model

import kneecore
from kneecore import InfluenceSettings, SamplingSettings, SearchSettings


def tell(title, pair):
    """Print a pair: how far apart, whether to be trusted, and its parts."""
    print(f"{title}: f {pair.objective_model:.1f} dB. {pair.verdict}")
    for k, x in enumerate(pair.x, start=1):
        parts = zip(pair.model.names, 100.0 * (x / pair.model.nominal - 1.0), strict=True)
        print(f"  filter {k}: " + ", ".join(f"{name} {part:+.1f} %" for name, part in parts))


filter_ = model()
pair = kneecore.worst_case(filter_)
tell("All frequencies", pair)
apart = np.abs(pair.y[0] - pair.y[1])
at = int(np.argmax(apart))
print(f"  most apart at {FREQUENCY[at] / 1e3:.1f} kHz: {apart[at]:.1f} dB")

study = kneecore.monte_carlo(filter_, SamplingSettings(n_samples=10_000))
band = study.y.percentile_upper - study.y.percentile_lower
print(f"  99.7 % of 10,000 filters are within {band[at]:.1f} dB there")

passed = (FREQUENCY > 8.5e3) & (FREQUENCY < 11.8e3)
ripple = kneecore.worst_case(filter_, SearchSettings(weights=passed * 1.0))
tell(f"The pass band alone, {ripple.counts['models_simulated']} runs", ripple)

decide = kneecore.influence(filter_, InfluenceSettings(n_base=256))
for k in (3, 12, 21):
    print(f"{FREQUENCY[k] / 1e3:.1f} kHz is decided by {' and '.join(decide.deciding(k, 2))}")

pair.figures()["figure_1_outputs"].savefig("all.png", dpi=90)
ripple.figures()["figure_1_outputs"].savefig("pass_band.png", dpi=90)
