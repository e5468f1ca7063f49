"""The server: one page for all visitors, or one for each."""

import contextlib
import io
import logging
from collections.abc import Sequence

import viser

import kneecore
from kneecore import KneeFile, SearchResult
from kneeviz import viser_broadcast, viser_internals
from kneeviz.actions.result import take_result
from kneeviz.geometry import framing
from kneeviz.jobs import uploads
from kneeviz.page.page import Clients, Page, Target
from kneeviz.server import front
from kneeviz.server.gate import Gate
from kneeviz.server.kernels import KernelWarmUp
from kneeviz.server.seats import NoRoom, Seats
from kneeviz.server.session import Session
from kneeviz.state import results
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
    knee : KneeFile, optional
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
    kernels : KernelWarmUp, optional
        One that was started earlier.

    Raises
    ------
    ParameterError
        If `result` is of a model that is no knee.
    """

    def __init__(
        self,
        *,
        host: str = "127.0.0.1",
        port: int = 8080,
        knee: KneeFile | None = None,
        result: SearchResult | None = None,
        shared: bool = True,
        token: str | bool | None = None,
        allow_hosts: Sequence[str] = (),
        kernels: KernelWarmUp | None = None,
    ) -> None:
        self._knee = kneecore.packaged_knee() if knee is None else knee
        self._result = None if result is None else results.of_knees(result)
        self.shared = shared
        self.gate = Gate.of(host, token=token, allowed=allow_hosts)
        viser_internals.skip_client_build()
        viser_broadcast.install()
        viser_internals.know_array_types()
        # viser's banner is not shown: we print our own line.
        with contextlib.redirect_stdout(io.StringIO()), front.standing(self.gate):
            self.server = viser.ViserServer(host=host, port=port, label="kneeviz", verbose=False)
        viser_internals.refuse_tunnel(self.server)
        self.server.scene.world_axes.visible = False
        self._place_first_camera()
        self.warm_up = KernelWarmUp() if kernels is None else kernels
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

    @property
    def page(self) -> Page:
        """The shared session's page."""
        return self.session.page

    def stop(self) -> None:
        """End all sessions and free the port."""
        self.seats.close()
        for session in self._common.values():
            self._end(session)
        self._common = {}
        uploads.end_all()
        with contextlib.redirect_stdout(io.StringIO()):
            self.server.stop()

    def _place_first_camera(self) -> None:
        first = self.server.initial_camera
        first.fov = float(framing.FIELD_OF_VIEW)
        first.position = camera.position(camera.FIRST, camera.FRONT)
        first.look_at = camera.FIRST.centre
        first.up = (0.0, 1.0, 0.0)
        first.near, first.far = 0.1, 20.0

    def _new_session(self, target: Target, clients: Clients) -> Session:
        session = Session(target, self._knee, clients)
        if self._result is not None:
            take_result(session.page, self._result)
        session.start()
        self.warm_up.tell(session.post)
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
        self.warm_up.forget(session.post)
        session.stop()
