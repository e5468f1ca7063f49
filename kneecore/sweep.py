"""``python -m kneecore.sweep``: how many training runs, and how accurate a geometry."""

from kneecore.cli.sweep import main

if __name__ == "__main__":
    raise SystemExit(main())
