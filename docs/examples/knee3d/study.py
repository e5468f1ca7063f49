"""How different two knees within a millimetre can be, in three dimensions: ``python study.py``."""

import numpy as np

import kneecore
from kneecore import InfluenceSettings, Model, SamplingSettings


def main():
    """Search, sample, ask what decides, and draw."""
    knee = Model.from_file("knee3d.toml")
    pair = kneecore.worst_case(knee)
    print(f"f {pair.objective_model:.1f}. {pair.verdict}")
    print(f"runs {pair.counts['models_simulated']}, failed {pair.counts['models_failed']}")
    for name, y in (("as given", pair.y_nominal), ("knee 1", pair.y[0]), ("knee 2", pair.y[1])):
        turn, drawer = y[:6], y[6:]
        print(
            f"{name}: {turn[0]:.1f} to {turn[-1]:.1f} deg at 2 N m, "
            f"{drawer[0]:.1f} to {drawer[-1]:.1f} mm at 100 N"
        )

    study = kneecore.monte_carlo(knee, SamplingSettings(n_samples=100))
    band = study.y.percentile_upper - study.y.percentile_lower
    apart = np.abs(pair.y[0] - pair.y[1])
    print(f"at +2 N m: the pair {apart[5]:.1f} deg apart, 100 random knees within {band[5]:.1f}")

    # Sobol' indices need thousands of runs: those of a surrogate cost none.
    surrogate = kneecore.fit_surrogate(knee, n_samples=100)
    fast = Model(surrogate.predict, knee.inputs, knee.outputs, batched=True, name="its surrogate")
    decide = kneecore.influence(fast, InfluenceSettings(n_base=512))
    for column, what in ((0, "external rotation"), (5, "internal rotation"), (9, "drawer")):
        print(f"{what} is decided by {' and '.join(decide.deciding(column, 2))}")

    pair.figures()["figure_1_outputs"].savefig("knees.png", dpi=90)
    pair.figures()["figure_2_picture"].savefig("picture.png", dpi=90)
    knee.close()


if __name__ == "__main__":
    main()
