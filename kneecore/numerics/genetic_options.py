"""The genetic algorithm's constants, apart from its code: a command line shows them fast."""

import math
from dataclasses import dataclass, fields
from numbers import Real

from kneecore._arguments import shown
from kneecore.errors import ParameterError


@dataclass(frozen=True, kw_only=True)
class GeneticOptions:
    """Constants of the genetic algorithm. Defaults are the paper's where it gives them."""

    crossover_fraction: float = 0.7
    """Share of the next generation made by crossover (paper)."""
    mutation_fraction: float = 0.2
    """Share made by mutation (paper)."""
    elite_fraction: float = 0.1
    """Share of the best that live on unchanged (paper)."""
    blx_alpha: float = 0.5
    """Widening of the parents' interval in the crossover (paper)."""
    mutation_b: float = 5.0
    """How fast mutation steps shrink over the generations (paper)."""
    rank_eta_min: float = 0.0
    """Expected offspring of the worst rank; the best has 2 - eta_min, linear between. The paper
    says `rank-based` only. 0 is the strongest linear pressure: with the 0.75 of Herrera et al. a
    100 x 100 search ends several per cent lower (see the benchmarks)."""
    gene_mutation_probability: float = 0.05
    """Chance of each gene of a mutated child to change; at least one always does. The paper is
    silent; a 100 x 100 search ends a little lower where all genes mutate."""

    def __post_init__(self) -> None:
        for option in fields(self):
            value = getattr(self, option.name)
            if isinstance(value, bool) or not isinstance(value, Real):
                raise ParameterError(f"`{option.name}` is {shown(value)}; a number is allowed")
            object.__setattr__(self, option.name, float(value))
        shares = (self.crossover_fraction, self.mutation_fraction, self.elite_fraction)
        if not (min(shares) > 0.0 and abs(sum(shares) - 1.0) <= 1e-9):
            raise ParameterError(
                "`crossover_fraction`, `mutation_fraction`, `elite_fraction` are "
                f"{shares[0]:g}, {shares[1]:g}, {shares[2]:g}; three positive shares with sum 1 "
                "are allowed"
            )
        allowed = {
            "blx_alpha": (0.0, 100.0),
            "mutation_b": (0.0, 1000.0),
            "rank_eta_min": (0.0, 1.0),
            "gene_mutation_probability": (0.0, 1.0),
        }
        for name, (low, high) in allowed.items():
            value = getattr(self, name)
            if not low <= value <= high:
                raise ParameterError(f"`{name}` is {value:g}; {low:g} to {high:g} is allowed")

    def split(self, pop_size: int) -> tuple[int, int, int]:
        """Return the numbers of elite, crossover and mutation children.

        Raises
        ------
        ParameterError
            If one of them would be zero.
        """
        shares = (self.crossover_fraction, self.mutation_fraction, self.elite_fraction)
        smallest = math.ceil(1.0 / min(shares) - 1e-9)
        if pop_size < smallest:
            raise ParameterError(
                f"`pop_size` is {pop_size}; at least {smallest} is allowed, so that crossover, "
                "mutation and elite get one individual each"
            )
        n_elite = int(self.elite_fraction * pop_size + 0.5 + 1e-9)
        n_mutation = int(self.mutation_fraction * pop_size + 0.5 + 1e-9)
        return n_elite, pop_size - n_elite - n_mutation, n_mutation
