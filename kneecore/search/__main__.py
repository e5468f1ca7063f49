"""``python -m kneecore.search``: the two most different models within bounds.

The command line is above this room, and is found by its name.
"""

from importlib import import_module

if __name__ == "__main__":
    raise SystemExit(import_module("kneecore.cli.search").main())
