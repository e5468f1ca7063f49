"""The server: one page for all visitors, or one for each."""

import contextlib
import io
import logging
import threading

import viser

import kneecore
from kneecore import Knee, KneecoreError, SearchResult
from kneeviz import viser_internals
from kneeviz.actions.result import take_result
from kneeviz.page.page import Clients, Page, Target
from kneeviz.server.kernels import KernelWarmUp
from kneeviz.server.session import Session
from kneeviz.views.scene import camera

_LOG = logging.getLogger(__name__)
MAX_SESSIONS = 16
"""Most visitors with a knee of their own."""


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
    """

    def __init__(
        self,
        *,
        host: str = "127.0.0.1",
        port: int = 8080,
        knee: Knee | None = None,
        result: SearchResult | None = None,
        shared: bool = True,
    ) -> None:
        self._knee = kneecore.packaged_knee() if knee is None else knee
        self._result, self.shared = result, shared
        viser_internals.skip_client_build()
        with contextlib.redirect_stdout(io.StringIO()):  # viser's banner: we print our own line
            self.server = viser.ViserServer(host=host, port=port, label="kneeviz", verbose=False)
        viser_internals.refuse_tunnel(self.server)
        self.server.scene.world_axes.visible = False
        self._place_first_camera()
        self.sessions: dict[int | None, Session] = {}
        self._lock = threading.Lock()
        self.warm_up = KernelWarmUp()
        if shared:
            self.sessions[None] = self._new_session(self.server, self.server.get_clients)
        self.server.on_client_connect(self._join)
        self.server.on_client_disconnect(self._leave)
        self.warm_up.start()

    @property
    def url(self) -> str:
        """The address to open in a browser."""
        host = self.server.get_host()
        shown = "127.0.0.1" if host in ("0.0.0.0", "::") else host
        return f"http://{shown}:{self.server.get_port()}"

    @property
    def session(self) -> Session:
        """The shared session."""
        return self.sessions[None]

    @property
    def page(self) -> Page:
        """The shared session's page."""
        return self.session.page

    def stop(self) -> None:
        """End all sessions and free the port."""
        with self._lock:
            sessions, self.sessions = list(self.sessions.values()), {}
        for session in sessions:
            self.warm_up.forget(session.post)
            session.stop()
        with contextlib.redirect_stdout(io.StringIO()):
            self.server.stop()

    def _place_first_camera(self) -> None:
        first = self.server.initial_camera
        first.fov = float(camera.FIELD_OF_VIEW)
        first.position = camera.knee_position(False)
        first.look_at = camera.CENTRE
        first.up = (0.0, 1.0, 0.0)
        first.near, first.far = 0.1, 20.0

    def _new_session(self, target: Target, clients: Clients) -> Session:
        session = Session(target, self._knee, clients)
        if self._result is not None:
            take_result(session.page, self._result)
        session.start()
        self.warm_up.tell(session.post)
        return session

    def _join(self, client: viser.ClientHandle) -> None:
        if self.shared:
            self.session.post(("joined", client.client_id))
            return
        with self._lock:
            full = len(self.sessions) >= MAX_SESSIONS
        if full:
            client.add_notification(
                "No room", f"{MAX_SESSIONS} visitors are here already. Please come back later."
            )
            return
        try:
            session = self._new_session(client, lambda: {client.client_id: client})
        except KneecoreError:
            _LOG.exception("a visitor's session cannot be made")
            return
        with self._lock:
            self.sessions[client.client_id] = session
        session.post(("joined", client.client_id))

    def _leave(self, client: viser.ClientHandle) -> None:
        with self._lock:
            session = None if self.shared else self.sessions.pop(client.client_id, None)
        if session is not None:
            self.warm_up.forget(session.post)
            session.stop()
