"""``python -m kneecore.sweep``: how many training runs, how accurate a geometry, at what cost."""

from kneecore.cli.sweep import main

if __name__ == "__main__":
    raise SystemExit(main())
