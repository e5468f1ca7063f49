"""What a search's figures are called, for those who name them without drawing."""

__all__ = [
    "AP_POSITION",
    "CONVERGENCE",
    "FORCES",
    "GEOMETRY",
    "MOMENT_ANGLE",
    "OUTPUTS",
    "PICTURE",
    "REPAIR",
    "SEARCH_FILES",
]

MOMENT_ANGLE, FORCES = "figure_1_moment_angle", "figure_3_ligament_forces"
AP_POSITION, GEOMETRY = "figure_4_ap_displacement", "figure_2_geometry"
OUTPUTS, PICTURE = "figure_1_outputs", "figure_2_picture"
REPAIR, CONVERGENCE = "figure_5_repair", "figure_6_convergence"
SEARCH_FILES = tuple(
    f"{name}.{ending}"
    for name in (
        *(MOMENT_ANGLE, FORCES, AP_POSITION, GEOMETRY),
        *(OUTPUTS, PICTURE, REPAIR, CONVERGENCE),
    )
    for ending in ("png", "svg")
)
"""Names of all files that a search's figures may be in."""
