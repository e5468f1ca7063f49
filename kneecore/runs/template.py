"""Input files with fields such as ``{k_1}`` or ``{k_1:.6e}`` in the place of numbers."""

import re
from collections.abc import Mapping, Sequence, Set

from kneecore._arguments import shown
from kneecore.errors import ParameterError

__all__ = ["fields_in", "filled"]


def _pattern(names: Sequence[str]) -> re.Pattern[str]:
    # Other braces are the program's own: JSON is full of them.
    known = "|".join(re.escape(name) for name in sorted(names, key=len, reverse=True))
    return re.compile(r"\{(" + known + r")(?::([^{}\n]*))?\}")


def fields_in(template: str, names: Sequence[str], whole: Set[str] = frozenset()) -> set[str]:
    """Return which of the inputs have a field in a text; some are `whole` numbers.

    Raises
    ------
    ParameterError
        If a field's format is none that a number can have.
    """
    found = set()
    for field in _pattern(names).finditer(template):
        found.add(field[1])
        if field[2] is not None:
            try:
                format(1 if field[1] in whole else 1.0, field[2])
            except ValueError:
                raise ParameterError(
                    f"`template` has the field {shown(field[0])}; a format of a number such as "
                    "{k:.6e} is allowed"
                ) from None
    return found


def filled(template: str, values: Mapping[str, float]) -> str:
    """Return a text with its fields replaced; without a format a number has all its digits."""

    def number(field: re.Match[str]) -> str:
        value = values[field[1]]
        return repr(value) if field[2] is None else format(value, field[2])

    return _pattern(list(values)).sub(number, template)
