"""What another process compiles of a search at the first start, by name: no numba is loaded."""

__all__ = ["GENERATIONS"]

GENERATIONS = "kneecore.search.warm_up:compile_generations"
"""The genetic algorithm in a surrogate: the larger half of a first search's kernels."""
