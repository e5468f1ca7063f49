"""``python -m kneecore.uncertainty``: Monte Carlo, influence, and a worst case beside them."""

from kneecore.cli.uncertainty import main

if __name__ == "__main__":
    raise SystemExit(main())
