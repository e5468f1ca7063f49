"""The command ``python -m kneeviz``: the knee, or a model of one's own, in the browser.

viser, numba and the rest are imported only after the options are read, so that ``--help`` and a
wrong option answer at once.
"""

import os
import signal
import sys
import threading
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

import tyro

from kneecore.cli import run
from kneecore.errors import KneecoreError

if TYPE_CHECKING:
    from kneeviz.server.app import App

COMMAND = "python -m kneeviz"
TOKEN_VARIABLE = "KNEEVIZ_TOKEN"
DEFAULT_PORT = 8080
_PORTS_TRIED = 100
_File = Annotated[str | None, tyro.conf.arg(metavar="FILE")]
_Names = Annotated[tuple[str, ...], tyro.conf.arg(metavar="NAME"), tyro.conf.UseAppendAction]
_Text = Annotated[str | None, tyro.conf.arg(metavar="TEXT")]
_Port = Annotated[int | None, tyro.conf.arg(metavar="PORT")]


@dataclass(frozen=True, kw_only=True)
class Options:
    """Show the knee, or a model of your own, in the browser: sliders, live curves, worst cases.

    The packaged baseline is a reconstruction of the knee of Ciszkiewicz & Dumas 2024, whose
    parameter table is not available.
    """

    host: str = "127.0.0.1"
    """Address to listen on. The default can be reached from this machine only. On any other, the
    printed address carries a token, without which nobody is let in."""
    port: _Port = None
    """Port to listen on. Unset: 8080, or the next free one."""
    baseline: _File = None
    """A knee file (TOML) to start from instead of the packaged baseline."""
    model: _File = None
    """A model of your own (TOML) in the knee's place: inputs, outputs, and a function or a program.
    It names code that is run."""
    result: _File = None
    """A search's result.json, or the folder that holds it, to open with."""
    knee: _Text = None
    """What a copied link has after `?knee=`: the knee, bounds and settings to open with."""
    state: _File = None
    """A file that keeps the knee and its bounds, or the inputs of your model, the settings and the
    result of the shared page as they change. If it is there, the page opens as it was left."""
    shared: bool = False
    """All visitors see the same knee: what one does, all see. This is the default."""
    per_visitor: bool = False
    """Each visitor has a knee of his own."""
    for_class: Annotated[bool, tyro.conf.arg(name="class")] = False
    """Of the two printed addresses the first is the teacher's, who drives. Who opens the second
    only watches, until the teacher gives him the wheel or lets everybody drive."""
    token: bool = False
    """Let nobody in without the token in the printed address. This is the default where others
    than this machine can reach the app. The environment variable KNEEVIZ_TOKEN, if set, is it."""
    no_token: bool = False
    """Let everybody in who can reach the app."""
    allow_host: _Names = ()
    """A further name under which the app is reached, through a reverse proxy or a tunnel. May be
    given several times."""
    no_browser: bool = False
    """Do not open the browser."""


def port_is_free(host: str, port: int) -> bool:
    """Tell whether a server could listen on `port`.

    Raises
    ------
    OSError
        If `host` is no address of this machine.
    """
    import errno
    import socket

    family, kind, protocol, _, address = socket.getaddrinfo(
        host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
    )[0]
    with socket.socket(family, kind, protocol) as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind(address)
        except OSError as error:
            if error.errno in (errno.EADDRINUSE, errno.EACCES):
                return False
            raise
    return True


def choose_port(host: str, port: int | None) -> int:
    """Return the port to listen on: the one asked for, or the first free one from 8080.

    Raises
    ------
    ParameterError
        If the port that was asked for is taken or no port, or the host is none of this machine's.
    """
    from kneecore.errors import ParameterError

    if port is not None and not 0 <= port <= 65535:
        raise ParameterError(f"`port` is {port}; 0 to 65535 is allowed")
    try:
        if port is not None:
            if port != 0 and not port_is_free(host, port):
                raise ParameterError(f"`port` {port} is in use; another one is needed")
            return port
        for candidate in range(DEFAULT_PORT, DEFAULT_PORT + _PORTS_TRIED):
            if port_is_free(host, candidate):
                return candidate
    except OSError as error:
        raise ParameterError(f"`host` {host!r} cannot be used: {error.strerror or error}") from None
    raise ParameterError(f"no port from {DEFAULT_PORT} on is free; give one with --port")


def chosen_token(options: Options) -> str | bool | None:
    """Return the token that was asked for; None leaves it to the host.

    Raises
    ------
    ParameterError
        If it is both asked for and not wanted.
    """
    from kneecore.errors import ParameterError

    if options.token and options.no_token:
        raise ParameterError("--token and --no-token are given; only one of them is allowed")
    if options.no_token:
        return False
    return os.environ.get(TOKEN_VARIABLE) or (True if options.token else None)


def start(options: Options) -> "App":
    """Read the files, choose the port and start the server."""
    from kneecore.errors import ParameterError
    from kneecore.knee.ahead import compile_ahead

    if options.shared and options.per_visitor:
        raise ParameterError("--shared and --per-visitor are given; only one of them is allowed")
    for name in ("baseline", "knee"):
        if options.model is not None and getattr(options, name) is not None:
            raise ParameterError(
                f"`{name}` is {getattr(options, name)!r}; it is the knee's, and with `model` "
                "there is none"
            )
    if options.knee is not None and (options.baseline or options.state) is not None:
        raise ParameterError("--knee is given with --baseline or --state; it holds both itself")
    if options.state is not None and options.per_visitor:
        raise ParameterError("--state and --per-visitor are given; only one of them is allowed")
    if options.for_class and options.per_visitor:
        raise ParameterError("--class and --per-visitor are given; only one of them is allowed")
    token = chosen_token(options)
    port = choose_port(options.host, options.port)
    if options.model is None:
        compile_ahead()  # while numba, viser and the rest are imported here
    from kneecore import Model, read_knee

    knee = None if options.baseline is None else read_knee(options.baseline)
    model = None if options.model is None else Model.from_file(options.model)
    result = None
    if options.result is not None:
        from kneecore import SearchResult

        result = SearchResult.load(options.result)
    from kneeviz.server.app import App

    app = App(
        host=options.host,
        port=port,
        knee=knee,
        model=model,
        result=result,
        shared=not options.per_visitor,
        token=token,
        allow_hosts=options.allow_host,
        state=options.state,
        link=options.knee,
        for_class=options.for_class,
    )
    # Somebody else may have taken the port meanwhile; the server then moved on by itself.
    if options.port not in (None, 0, app.server.get_port()):
        app.stop()
        raise ParameterError(f"`port` {port} is in use; another one is needed")
    return app


def _serve(app: "App", stop: threading.Event, *, browser: bool) -> None:
    """Print the address, open it, and wait for Ctrl-C or a polite end."""
    # viser warns of clients that left meanwhile and of odd uploads: strangers' doing, not faults.
    for start_of_message in ("Queued a ", r"\[viser\] "):
        warnings.filterwarnings("ignore", start_of_message, UserWarning)
    if app.warning is not None:
        print(f"kneeviz: warning: {app.warning}", file=sys.stderr, flush=True)  # noqa: T201
    print(f"kneeviz: {app.url}  (Ctrl-C ends it)", flush=True)  # noqa: T201
    if app.class_url is not None:
        print(f"kneeviz: {app.class_url}  (for the class, which watches)", flush=True)  # noqa: T201
    if browser:
        import webbrowser

        threading.Thread(target=webbrowser.open, args=(app.url,), daemon=True).start()
    while not stop.wait(0.5):
        pass


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code.

    Ctrl-C is how it ends, and no failure: 0. A polite end (SIGTERM) is 143, as in other commands.
    """
    options = run.parse(Options, arguments, COMMAND)
    try:
        # From the start on: numba swallows Ctrl-C while it compiles.
        with run.undisturbed() as stop:
            app = start(options)
            try:
                if not stop.is_set():
                    _serve(app, stop, browser=not options.no_browser)
            finally:
                app.stop()
    except KneecoreError as error:
        return run.fail(COMMAND, error)
    except KeyboardInterrupt:  # pressed twice
        pass
    return 0 if run.stop_code() == 128 + signal.SIGINT else run.stop_code()


if __name__ == "__main__":
    sys.exit(main())
