"""How different two linkages made to a tenth of a millimetre can be: ``python study.py``."""

import kneecore

linkage = kneecore.Model.from_file("four_bar.toml")
pair = kneecore.worst_case(linkage)
print(f"f {pair.objective_model:.3f} mm. {pair.verdict}")
for k, (x, y) in enumerate(zip(pair.x, pair.y, strict=True), start=1):
    off = zip(linkage.names, x - linkage.nominal, strict=True)
    lengths = ", ".join(f"{name} {length:+.1f}" for name, length in off)
    print(f"linkage {k}: {lengths} mm; height {y.min():.3f} to {y.max():.3f} mm")
print(f"as designed: height {pair.y_nominal.min():.3f} to {pair.y_nominal.max():.3f} mm")

decide = kneecore.influence(linkage, kneecore.InfluenceSettings(n_base=256))
print("At half a turn " + " and ".join(decide.deciding(8, 2)) + " decide")

pair.figures()["figure_2_picture"].savefig("linkages.png", dpi=90)
pair.figures()["figure_1_outputs"].savefig("heights.png", dpi=90)
