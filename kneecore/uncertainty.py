"""``python -m kneecore.uncertainty``: Monte Carlo, influence, and a worst case beside them."""

from kneecore.study.cli import main

if __name__ == "__main__":
    raise SystemExit(main())
