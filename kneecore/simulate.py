"""``python -m kneecore.simulate``: one knee's response as a table."""

if __name__ != "__main__":  # imported, it would take the place of the function of that name
    raise ImportError("kneecore.simulate is a command here; `from kneecore import simulate` works")

from kneecore.cli.simulate import main

raise SystemExit(main())
