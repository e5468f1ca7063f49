"""The server: one view for all visitors, or one for each, and the kernels' warm-up behind it."""

import contextlib
import io
import logging
import threading
from collections.abc import Callable, Sequence
from typing import Any

import viser
import viser._client_autobuild

import kneecore
from kneecore import Knee
from kneecore.search.result import SearchResult
from kneecore.search.warm_up import warm_up
from kneeviz import viser_internals as wire
from kneeviz.actions.result import take_result
from kneeviz.server import front
from kneeviz.server.gate import Gate
from kneeviz.server.seats import NoRoom, Seats
from kneeviz.server.session import Session
from kneeviz.views.scene import knee as scene

_LOG = logging.getLogger(__name__)
MAX_SESSIONS = 16
"""Most visitors with a knee of their own."""


class KernelWarmUp:
    """Compiles or loads the kernels on a thread of its own and tells who waits for them."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._done: list[str] = []
        self._waiting: list[Session] = []
        self._thread = threading.Thread(target=self._run, name="warm-up", daemon=True)

    def start(self) -> None:
        """Start compiling."""
        self._thread.start()

    def tell(self, session: Session) -> None:
        """Tell `session` what is ready, now and later."""
        with self._lock:
            self._waiting.append(session)
            for what in self._done:
                session.post(("ready", what))

    def forget(self, session: Session) -> None:
        """Tell `session` no more."""
        with self._lock:
            if session in self._waiting:
                self._waiting.remove(session)

    def _announce(self, what: str) -> None:
        with self._lock:
            self._done.append(what)
            for session in self._waiting:
                session.post(("ready", what))

    def _run(self) -> None:
        try:
            baseline = kneecore.packaged_knee().baseline
            kneecore.simulate(baseline)
            self._announce("model")
            kneecore.trajectory(baseline)
            warm_up("surrogate")
            warm_up("model")
            self._announce("search")
            warm_up("model", method="exact", solver="equilibrium")
            self._announce("exact")
        except Exception as error:
            _LOG.exception("the kernels cannot be compiled")
            with self._lock:
                for session in self._waiting:
                    session.post("not_ready", error)


class App:
    """A running server with its sessions.

    Parameters
    ----------
    host, port
        Where to listen; 0 takes a free port, a busy one moves on to the next.
    knee : Knee, optional
        The baseline; the packaged one for None.
    result : SearchResult, optional
        A search's result to open with.
    shared : bool
        Whether all visitors see one knee, or each has his own.
    token : str or bool, optional
        What the address must carry: a text, True for a new one, False for nothing; by default a
        new one where others than this machine can reach the server.
    allow_hosts : sequence of str
        Names under which the server is reached through a proxy or a tunnel.
    """

    def __init__(
        self,
        *,
        host: str = "127.0.0.1",
        port: int = 8080,
        knee: Knee | None = None,
        result: SearchResult | None = None,
        shared: bool = True,
        token: str | bool | None = None,
        allow_hosts: Sequence[str] = (),
    ) -> None:
        self._knee = kneecore.packaged_knee() if knee is None else knee
        self._result, self.shared = result, shared
        self.gate = Gate.of(host, token=token, allowed=allow_hosts)
        # An installed client is always built; looking for a compiler for it may take long.
        viser._client_autobuild.ensure_client_is_built = lambda: None
        # viser's banner is not shown: we print our own line.
        with contextlib.redirect_stdout(io.StringIO()), front.standing(self.gate):
            self.server = viser.ViserServer(host=host, port=port, label="kneeviz", verbose=False)
        wire.refuse_tunnel(self.server)
        self.server.scene.world_axes.visible = False
        self._place_first_camera()
        self.warm_up = KernelWarmUp()
        self.seats: Seats[Session] = Seats(MAX_SESSIONS, self._end)
        self._common: dict[int | None, Session] = {}
        if shared:
            self._common[None] = self._new_session(self.server, self.server.get_clients)
        self.server.on_client_connect(self._join)
        self.server.on_client_disconnect(self._leave)
        self.warm_up.start()

    @property
    def url(self) -> str:
        """The address to open in a browser."""
        return self.gate.url(self.server.get_port())

    @property
    def warning(self) -> str | None:
        """What may go wrong where others can reach the server, or None."""
        return self.gate.warning(self.server.get_port())

    @property
    def sessions(self) -> dict[int | None, Session]:
        """The sessions by their client's number; the shared one's is None."""
        return self._common | dict(self.seats.made.items())

    @property
    def session(self) -> Session:
        """The shared session."""
        return self._common[None]

    def stop(self) -> None:
        """End all sessions and free the port."""
        self.seats.close()
        for session in self._common.values():
            self._end(session)
        self._common = {}
        with contextlib.redirect_stdout(io.StringIO()):
            self.server.stop()

    def _place_first_camera(self) -> None:
        camera = self.server.initial_camera
        camera.fov = float(scene.FIELD_OF_VIEW)
        camera.position = scene.camera_position(False)
        camera.look_at = scene.CENTRE
        camera.up = (0.0, 1.0, 0.0)
        camera.near, camera.far = 0.1, 20.0

    def _new_session(self, target: Any, clients: Callable[[], dict[int, Any]]) -> Session:
        session = Session(target, self._knee, clients)
        if self._result is not None:
            take_result(session, self._result)
        session.start()
        self.warm_up.tell(session)
        return session

    def _session_of(self, client: viser.ClientHandle) -> Session | None:
        if client.client_id not in self.server.get_clients():
            return None  # gone while this waited for its turn
        return self._new_session(client, lambda: {client.client_id: client})

    def _join(self, client: viser.ClientHandle) -> None:
        if self.shared:
            self.session.post(("joined", client.client_id))
            return
        try:
            session = self.seats.join(client.client_id, lambda: self._session_of(client))
        except NoRoom:
            client.add_notification(
                "No room", f"{MAX_SESSIONS} visitors are here already. Please come back later."
            )
        except Exception:
            _LOG.exception("a visitor's session cannot be made")
        else:
            if session is not None:
                session.post(("joined", client.client_id))

    def _leave(self, client: viser.ClientHandle) -> None:
        if not self.shared:
            self.seats.leave(client.client_id)

    def _end(self, session: Session) -> None:
        self.warm_up.forget(session)
        session.stop()
