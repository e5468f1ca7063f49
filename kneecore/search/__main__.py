"""Entry point of ``python -m kneecore.search``."""

from kneecore.cli.search import main

if __name__ == "__main__":
    raise SystemExit(main())
