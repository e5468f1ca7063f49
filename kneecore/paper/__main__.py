"""``python -m kneecore.paper``: the paper redone and judged claim by claim.

The command line is above this room, and is found by its name.
"""

from importlib import import_module

if __name__ == "__main__":
    raise SystemExit(import_module("kneecore.cli.paper").main())
