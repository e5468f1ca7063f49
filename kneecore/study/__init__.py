"""Uncertainty: sampling, influence, and the worst case held against them. Names in `kneecore`."""
