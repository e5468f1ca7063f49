"""Commands whose names are those of rooms: ``python -m kneecore.search`` and ``kneecore.paper``.

Their command lines stand above the rooms; nothing in a room knows them, so they are found by name.
"""

from importlib import import_module


def run_command(name: str) -> int:
    """Run a command line by its name and return its exit code."""
    code: int = import_module(f"kneecore.cli.{name}").main()
    return code
