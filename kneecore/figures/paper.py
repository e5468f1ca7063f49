"""The report's figures: the paper's four, its supplement's two cases, the band, and influence."""

from collections.abc import Mapping

from matplotlib.figure import Figure

from kneecore.figures.influence import bars_figure
from kneecore.figures.monte_carlo import band_figure
from kneecore.figures.search import draw as draw_search
from kneecore.paper.result import PaperReport

__all__ = ["CAPTIONS", "INFLUENCE_FIGURE", "draw"]

INFLUENCE_FIGURE = "figure_influence"
CAPTIONS: Mapping[str, str] = {
    "figure_1_moment_angle": "Figure 1. External moment against knee angle: the training knees of "
    "the surrogate, the baseline and the two worst cases, all by the true model.",
    "figure_1_band": "Figure 1, beside sampling. The worst cases in front of the band that holds "
    "99.7 % of the sampled knees, and mean ± 3 sd as in the paper.",
    "figure_2_geometry": "Figure 2. The baseline and the two worst cases in the load-free pose.",
    "figure_3_ligament_forces": "Figure 3. Ligament tensions against knee angle.",
    "figure_4_ap_displacement": "Figure 4. Contact position on the plateau against knee angle.",
    "figure_s1_geometry_only": "Supplement. Moment against angle where only the geometry varies.",
    "figure_s2_material_only": "Supplement. Moment against angle where only the material varies.",
    INFLUENCE_FIGURE: "Total Sobol' indices at the largest moments, with 95 % intervals.",
}
"""File names without an ending, in the report's order, and what the figures show."""


def draw(report: PaperReport) -> dict[str, Figure]:
    """Return the figures by the names of `CAPTIONS`; none for a report read from a file."""
    done = report.experiments
    if done is None:
        return {}
    drawn = draw_search(done.main)
    drawn["figure_1_band"] = band_figure(done.sampling, done.main)
    drawn[INFLUENCE_FIGURE] = bars_figure(done.influence)
    for name, case in (
        ("figure_s1_geometry_only", "geometry"),
        ("figure_s2_material_only", "material"),
    ):
        figure = draw_search(done.cases[case])["figure_1_moment_angle"]
        figure.axes[0].set_title(f"Moment against angle, {case} only")
        drawn[name] = figure
    return {name: drawn[name] for name in CAPTIONS}
