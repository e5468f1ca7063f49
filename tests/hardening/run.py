"""Try to break it for some minutes and print the table of what was injected and what happened.

Run with ``python tests/hardening/run.py``; ``--short`` takes seconds a row, ``--only WORD`` the
rows whose name has that word. The exit code is 1 if something that happened should not.
"""

import argparse
import importlib
import sys
import warnings
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent), str(HERE.parents[1])]

from hardening.rows import LONG, ROWS, SHORT, Outcome, Scale, table  # noqa: E402


def load_rows() -> None:
    """Import every module of rows beside this one."""
    for path in sorted(HERE.glob("rows_*.py")):
        importlib.import_module(f"hardening.{path.stem}")


def run(scale: Scale, word: str = "") -> dict[str, Outcome]:
    """Run the rows whose name has `word`, and tell on stderr how each went."""
    outcomes = {}
    for name, attack in ROWS.items():
        if word.lower() not in name.lower():
            continue
        print(f"{name} ...", file=sys.stderr, flush=True)
        try:
            outcomes[name] = attack(scale)
        except Exception as error:
            outcomes[name] = Outcome(
                injected="-", happened=f"{type(error).__name__}: {error}", sound=False
            )
        print(f"  {outcomes[name].happened}", file=sys.stderr, flush=True)
    return outcomes


def main() -> int:
    """Run the rows, print the table, and tell whether all is sound."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--short", action="store_true", help="seconds a row instead of minutes")
    parser.add_argument("--seconds", type=float, help="seconds of the rows that go by time")
    parser.add_argument("--only", default="", metavar="WORD", help="rows whose name has this word")
    options = parser.parse_args()
    scale = SHORT if options.short else LONG
    if options.seconds is not None:
        scale = Scale(seconds=options.seconds, share=scale.share)
    warnings.filterwarnings("ignore", "Queued a ", UserWarning)  # viser's, for those who left
    load_rows()
    outcomes = run(scale, options.only)
    if not outcomes:
        parser.error(f"no row has {options.only!r} in its name")
    print(table(outcomes))
    return 0 if all(outcome.sound for outcome in outcomes.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
