"""What the command lines share: short messages, exit codes, Ctrl-C and its like.

Exit codes: 0 done, 1 the model gave no answer, 2 something asked for is not allowed, 130 Ctrl-C,
143 a polite end (SIGTERM), which is otherwise treated alike.
"""

import contextlib
import dataclasses
import io
import os
import re
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from types import FrameType
from typing import Any, TypeVar

import tyro

from kneecore.cli.terminal import Held, put, put_as_it_is, say
from kneecore.errors import KneecoreError, ModelError, OutputError, ParameterError

__all__ = [
    "DONE",
    "NOT_ALLOWED",
    "NO_ANSWER",
    "fail",
    "interrupted",
    "parse",
    "put",
    "run_cancellable",
    "say",
    "stop_code",
    "undisturbed",
]

DONE, NO_ANSWER, NOT_ALLOWED = 0, 1, 2
_STOPS = (signal.SIGINT, signal.SIGTERM)
PATIENCE = 0.6
"""Seconds that a computation gets to end itself after Ctrl-C."""

_T = TypeVar("_T")


def _open_streams() -> None:
    """Give a closed stdout or stderr somewhere to go, and let none fail on a table's lines."""
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115
        elif isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")


def parse(options: type[_T], arguments: Sequence[str] | None, command: str) -> _T:
    """Return the parsed options; a wrong one ends the process with one line and exit code 2."""
    _open_streams()
    _let_sigterm_interrupt()
    said, shown = io.StringIO(), Held()
    try:
        with contextlib.redirect_stderr(said), contextlib.redirect_stdout(shown):
            return tyro.cli(
                options,
                args=arguments,
                prog=command,
                config=(tyro.conf.FlagCreatePairsOff,),
            )
    except SystemExit as stop:
        if not stop.code:
            raise SystemExit(_help(shown.getvalue(), command)) from None
        say(command, f"{_first_sentence(said.getvalue())} (see --help)")
        raise SystemExit(NOT_ALLOWED) from None


def _help(text: str, command: str) -> int:
    try:
        put_as_it_is(text.removesuffix("\n"))
    except OutputError as error:
        return fail(command, error)
    return DONE


def _first_sentence(message: str) -> str:
    """Return what tyro's box says above its first rule: below is the option's whole help text."""
    said: list[str] = []
    for line in message.splitlines()[1:]:
        words = re.sub(r"\x1b\[[0-9;]*m", "", line).strip(" │")
        if words.startswith(("─", "╰", "---")):
            if said:
                break
            continue
        said.append(words)
    return " ".join(said) or "wrong options"


def fail(
    command: str, error: KneecoreError, options: object = None, names: Mapping[str, str] = {}
) -> int:
    """Print an error as one line and return its exit code.

    An argument of the library is shown as the option that sets it: those of `options`, a dataclass,
    by their own names, others by `names`.
    """
    flags = dict(names)
    if dataclasses.is_dataclass(options):
        flags |= {f.name: f"--{f.name.replace('_', '-')}" for f in dataclasses.fields(options)}
    line = re.sub(r"`(\w+)`", lambda found: f"`{flags.get(found[1], found[1])}`", str(error))
    say(command, line)
    return NO_ANSWER if isinstance(error, ModelError) else NOT_ALLOWED


class _Terminated(KeyboardInterrupt):
    """A polite end was asked for."""


_last_stop = signal.SIGINT


def _let_sigterm_interrupt() -> None:
    """Let a polite end be an interruption, unless somebody has other plans for it."""

    def handle(_signal: int, _frame: FrameType | None) -> None:
        global _last_stop
        _last_stop = signal.SIGTERM
        raise _Terminated

    main = threading.current_thread() is threading.main_thread()
    if main and signal.getsignal(signal.SIGTERM) is signal.SIG_DFL:
        signal.signal(signal.SIGTERM, handle)


def stop_code() -> int:
    """Return the exit code that tells by which signal the command was stopped."""
    return 128 + _last_stop


def interrupted(command: str, what: str) -> int:
    """Say that a command was interrupted and what of it is there; return the exit code."""
    say(command, what)
    return stop_code()


@contextlib.contextmanager
def _stops_set(event: threading.Event, *, only_once: bool = False) -> Iterator[None]:
    """Let Ctrl-C and SIGTERM set `event` instead of raising; with `only_once`, the next raises."""

    def handle(number: int, _frame: FrameType | None) -> None:
        global _last_stop
        _last_stop = signal.Signals(number)
        if only_once and event.is_set():
            raise KeyboardInterrupt
        event.set()

    before = {number: signal.signal(number, handle) for number in _STOPS}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextlib.contextmanager
def undisturbed() -> Iterator[threading.Event]:
    """Let Ctrl-C wait, as an event that is set, until the block is done; a second one does not."""
    stop = threading.Event()
    with _stops_set(stop, only_once=True):
        yield stop


def run_cancellable(
    work: Callable[[threading.Event], _T],
    command: str,
    close: Callable[[], object] = bool,
    way_on: Callable[[], str] = str,
) -> tuple[_T, bool]:
    """Run `work` on a thread while this one listens for Ctrl-C and SIGTERM.

    Parameters
    ----------
    work : callable
        Gets an event that is set when it should stop and return what it has.
    command : str
        Name for messages.
    close : callable
        Puts the terminal in order where the process has to be ended at once.
    way_on : callable
        Returns what is said then of how to go on.

    Returns
    -------
    tuple
        What `work` returned, and whether it was asked to stop.
    """
    stop = threading.Event()
    outcome: dict[str, Any] = {}

    def run() -> None:
        try:
            outcome["value"] = work(stop)
        except BaseException as error:
            outcome["error"] = error

    worker = threading.Thread(target=run, daemon=True, name=command)
    with _stops_set(stop):  # an exception would be swallowed by numba while it compiles
        worker.start()
        while worker.is_alive() and not stop.is_set():
            worker.join(0.05)
        worker.join(PATIENCE)
        if worker.is_alive():
            close()
            code = interrupted(command, f"interrupted; nothing was saved{way_on()}")
            os._exit(code)  # a compilation cannot be stopped in any other way
    if isinstance(outcome.get("error"), MemoryError):
        raise ModelError(f"out of memory: {outcome['error'] or 'a smaller task is needed'}")
    error = outcome.get("error")
    if isinstance(error, OSError) and not isinstance(error, KneecoreError):
        raise OutputError(str(error))  # such as a full disk under the kernels' cache
    if error is not None:
        raise error
    return outcome["value"], stop.is_set()


def check_step_check(asked: bool, solver: str) -> None:
    """Refuse the audit of a time step where there is none."""
    if asked and solver == "equilibrium":
        raise ParameterError(
            "`check_step` is given with the equilibrium solver, which has no time step; the "
            "dynamics solver is allowed"
        )
