"""Try to break it for some minutes and print the table of what was injected and what happened::

    python tests/hardening/run.py            # print
    python tests/hardening/run.py README.md  # and put it between the README's hardening marks

``--short`` takes seconds a row, ``--only WORD`` the rows whose name has that word: in the file the
others then stay as they are. The exit code is 1 if something that happened should not.
"""

import argparse
import importlib
import sys
import warnings
from pathlib import Path

BEGIN, END = "<!-- hardening: begin -->", "<!-- hardening: end -->"
HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent), str(HERE.parents[1])]

from hardening.rows import HEAD, LONG, ROWS, SHORT, Outcome, Scale, line, table  # noqa: E402


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


def between_marks(path: Path) -> tuple[str, str, str]:
    """Return what is before, between and behind a file's marks.

    Raises
    ------
    ValueError
        If it has not one of each.
    """
    text = path.read_text(encoding="utf-8") if path.is_file() else ""
    if text.count(BEGIN) != 1 or text.count(END) != 1:
        raise ValueError(f"`file` is {str(path)!r}; one with one {BEGIN} and one {END} is allowed")
    before, _, rest = text.partition(BEGIN)
    inside, _, after = rest.partition(END)
    return before, inside, after


def write(path: Path, outcomes: dict[str, Outcome]) -> None:
    """Put the rows into the table of a file; those that were not run stay."""
    before, inside, after = between_marks(path)
    stand = {
        name: old for name in ROWS for old in inside.splitlines() if old.startswith(f"| {name} |")
    }
    rows = stand | {name: line(name, outcome) for name, outcome in outcomes.items()}
    text = "\n".join([*HEAD, *(rows[name] for name in ROWS if name in rows)])
    new = path.with_name(path.name + ".new")
    new.write_text(f"{before}{BEGIN}\n{text}\n{END}{after}", encoding="utf-8")
    new.replace(path)


def main() -> int:
    """Run the rows, print the table, and tell whether all is sound."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--short", action="store_true", help="seconds a row instead of minutes")
    parser.add_argument("--seconds", type=float, help="seconds of the rows that go by time")
    parser.add_argument("--only", default="", metavar="WORD", help="rows whose name has this word")
    parser.add_argument("file", nargs="?", type=Path, help="where to put it, between its marks")
    options = parser.parse_args()
    try:
        if options.file is not None:  # before minutes are spent
            between_marks(options.file)
    except ValueError as error:
        parser.error(str(error))
    scale = SHORT if options.short else LONG
    if options.seconds is not None:
        scale = Scale(seconds=options.seconds, share=scale.share)
    warnings.filterwarnings("ignore", "Queued a ", UserWarning)  # viser's, for those who left
    load_rows()
    outcomes = run(scale, options.only)
    if not outcomes:
        parser.error(f"no row has {options.only!r} in its name")
    print(table(outcomes))
    if options.file is not None:
        write(options.file, outcomes)
    return 0 if all(outcome.sound for outcome in outcomes.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
