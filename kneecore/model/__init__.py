"""The 2D dynamic knee: forces, load-free pose, dynamics, response. It knows no optimiser."""
