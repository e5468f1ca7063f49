"""What a sampling is asked for, apart from its code: a command line shows it fast."""

from typing import Literal

from kneecore._arguments import LARGEST_COUNT, whole_number

__all__ = ["Sampling", "check_count", "check_seed"]

Sampling = Literal["uniform", "latin-hypercube", "sobol"]


def check_count(name: str, value: int) -> int:
    """Return `value` checked: a whole number of at least 1, and not above 2^31 - 1.

    Raises
    ------
    ParameterError
        If it is anything else; the message calls it `name`.
    """
    return whole_number(name, value, 1, LARGEST_COUNT, "a whole number from 1 to 2^31 - 1")


def check_seed(seed: int) -> int:
    """Return `seed` checked: a whole number from 0 to 2^63 - 1.

    Raises
    ------
    ParameterError
        If it is anything else.
    """
    return whole_number("seed", seed, 0, 2**63 - 1, "a whole number from 0 to 2^63 - 1")
