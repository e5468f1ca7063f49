"""``python -m kneecore.paper``: the paper redone and judged claim by claim."""

from kneecore.cli.paper import main

if __name__ == "__main__":
    raise SystemExit(main())
