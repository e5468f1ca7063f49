"""The command line that searches a model of one's own again."""

import shlex

from kneecore.model import Model
from kneecore.options import options_of
from kneecore.search.settings import SearchSettings

__all__ = ["model_command"]


def model_command(model: Model, settings: SearchSettings) -> str | None:
    """Return the command; None for a model that was not read from a file.

    The constants of the genetic algorithm are left out.
    """
    if model.file is None:
        return None
    words = ["python -m kneecore.search --model", shlex.quote(model.file)]
    for one in options_of(SearchSettings):
        value = getattr(settings, one.name)
        if value is None or value == one.default or one.name == "options":
            continue
        if one.open_flag:
            words.append(one.flag if value else f"--no-{one.key}")
            continue
        values = value if isinstance(value, tuple) else (value,)
        words += [one.flag] if value is True else [one.flag, *(shlex.quote(str(v)) for v in values)]
    return " ".join(words)
