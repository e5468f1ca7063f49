"""What sweeps go through unless told otherwise; without imports, so that `--help` is quick."""

BOUNDS_MM = (0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 2.5)
"""From below what medical images resolve to the accuracy that the paper quotes for them."""
SIZES = (30, 40, 50, 75, 100, 150, 200, 300, 400)
"""Training runs around the 50 that the paper argues for."""
