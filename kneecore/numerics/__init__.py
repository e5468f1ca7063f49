"""Sampling, surrogate and genetic algorithm. Nothing here knows a knee."""
