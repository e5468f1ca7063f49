"""The worst pair of a program's shafts, twice: ``python study.py``."""

import kneecore

shaft = kneecore.Model.from_file("shaft.toml")
settings = kneecore.SearchSettings(
    method="exact", repair=True, training_samples=10, repair_models=8
)
pair = kneecore.worst_case(shaft, settings)
print(f"f {pair.objective_model:.3f} mm. {pair.verdict}")
print(f"runs: {pair.counts['models_simulated']}, failed: {pair.counts['models_failed']}")
for k, (x, y) in enumerate(zip(pair.x, pair.y, strict=True), start=1):
    given = ", ".join(f"{name} {value:g}" for name, value in zip(shaft.names, x, strict=True))
    print(f"shaft {k}: {given}; {y[-1]:.3f} mm under the load")

again = kneecore.worst_case(shaft, settings)
print(f"asked again: {again.counts['models_reused']} runs taken from runs.jsonl")

shaft.evaluate([[206e3, 1000.0, 40.0, 32.0, -25.0]])
failure = shaft.failures[-1]
print(f"a shaft that cannot be: {failure.message}")
shaft.close()

pair.figures()["figure_1_outputs"].savefig("shaft.png", dpi=90)
