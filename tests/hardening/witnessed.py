"""Run a command as it is, and write down when it first uses what an earlier run has kept::

    python tests/hardening/witnessed.py FILE SECONDS all kneecore.cli.search --out DIR ...

FILE.begun is there when Python has read all that comes before the command's own lines, FILE when
something was used; SECONDS is how often a checkpoint is written, 1 as shipped; "numbers" in the
place of "all" leaves out the figures.
"""

import importlib
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from kneecore.files import checkpoint, folder
from kneecore.files.checkpoint import Checkpoint


def witness(told: Path) -> None:
    """Let checkpoints tell when something is taken from them."""
    run, load = Checkpoint.run, Checkpoint.load

    def tell(what: str) -> None:
        if not told.exists():
            told.write_text(f"{what}\n")

    def seen_run(self: Any, what: str, identity: bytes, given: Any, compute: Callable[[], Any]):
        computed = []
        answer = run(self, what, identity, given, lambda: computed.append(1) or compute())
        if not computed:
            tell(what)
        return answer

    def seen_load(self: Any, step: str):
        state = load(self, step)
        if state is not None:
            tell(step)
        return state

    Checkpoint.run, Checkpoint.load = seen_run, seen_load


def main() -> int:
    """Run the command that the arguments name."""
    told, interval, what, module, *arguments = sys.argv[1:]
    checkpoint.INTERVAL_S = float(interval)
    if what == "numbers":
        yielded = folder.contents
        folder.contents = lambda result, form, *, figures: yielded(result, form, figures=False)
    witness(Path(told))
    command = importlib.import_module(module).main
    Path(f"{told}.begun").touch()
    return command(arguments)


if __name__ == "__main__":
    sys.exit(main())
