"""``python -m kneecore.simulate``: one knee's response as a table."""

import sys

from kneecore.cli.simulate import main

if __name__ == "__main__":
    raise SystemExit(main())

# Importing this file as a module must not put it in the place of the function `kneecore.simulate`.
from kneecore.knee.response import simulate

sys.modules[__name__] = simulate  # type: ignore[assignment]
