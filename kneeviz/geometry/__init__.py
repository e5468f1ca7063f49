"""Points and meshes of knees and surfaces: pure functions."""
