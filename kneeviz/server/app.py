"""The server: one page for all visitors, or one for each."""

import contextlib
import io
import logging
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import viser

import kneecore
from kneecore import KneecoreError, KneeFile, Model, ParameterError, SearchResult
from kneecore.files.folder import write_file
from kneeviz import viser_broadcast, viser_internals
from kneeviz.actions.result import take_result
from kneeviz.anymodel import saved as model_saved
from kneeviz.anymodel.actions.search import take_result as take_model_result
from kneeviz.anymodel.session import ModelSession
from kneeviz.anymodel.state import of_this_model
from kneeviz.geometry import framing
from kneeviz.jobs import uploads
from kneeviz.jobs.keeper import Keeper
from kneeviz.page.page import Clients, Target
from kneeviz.server import front
from kneeviz.server.gate import Gate
from kneeviz.server.kernels import KernelWarmUp
from kneeviz.server.seats import NoRoom, Seats
from kneeviz.server.session import Session
from kneeviz.state import results, saved
from kneeviz.views.scene import camera

_LOG = logging.getLogger(__name__)
MAX_SESSIONS = 16
"""Most visitors with a knee of their own."""
Served = Session | ModelSession
"""One page and its loop."""


class App:
    """A running server with its sessions.

    Parameters
    ----------
    host, port
        Where to listen; 0 takes a free port, a busy one moves on to the next.
    knee : KneeFile, optional
        The baseline; the packaged one for None.
    model : Model, optional
        A model of one's own in the knee's place.
    result : SearchResult, optional
        A search's result to open with.
    shared : bool
        Whether all visitors see one knee, or each has his own.
    token : str or bool, optional
        What the address must carry: a text, True for a new one, False for nothing; by default a
        new one where others than this machine can reach the server.
    allow_hosts : sequence of str
        Names under which the server is reached through a proxy or a tunnel.
    state : path, optional
        A file in which the state of the shared page is kept; if it is there, the page opens as
        it was left.

    Raises
    ------
    ParameterError
        If `result` is of another model, a knee and a model are given, or `state` is given though
        visitors have pages of their own.
    FileFormatError
        If the file of the state cannot be read, or it or `result` is none of `model`.
    OutputError
        If the state cannot be written.
    """

    def __init__(
        self,
        *,
        host: str = "127.0.0.1",
        port: int = 8080,
        knee: KneeFile | None = None,
        model: Model | None = None,
        result: SearchResult | None = None,
        shared: bool = True,
        token: str | bool | None = None,
        allow_hosts: Sequence[str] = (),
        state: str | Path | None = None,
    ) -> None:
        if state is not None and not shared:
            raise ParameterError("`state` is given, but each visitor has a page of his own")
        if model is not None and knee is not None:
            raise ParameterError("`knee` and `model` are given; only one of them is allowed")
        self._knee = kneecore.packaged_knee() if knee is None else knee
        self._model, self._result = model, result
        left = None
        if state is not None and Path(state).exists():
            left = saved.read(state) if model is None else model_saved.read(state, model)
        if result is not None:
            self._result = (
                results.of_knees(result) if model is None else of_this_model(model, result)
            )
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
        self.warm_up = KernelWarmUp() if model is None else None
        self.seats: Seats[Served] = Seats(MAX_SESSIONS, self._end)
        self._common: dict[int | None, Served] = {}
        self._keeper: Keeper | None = None
        if shared:
            self._share(left, None if state is None else Path(state))
        self.server.on_client_connect(self._join)
        self.server.on_client_disconnect(self._leave)
        if self.warm_up is not None:
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
    def sessions(self) -> dict[int | None, Served]:
        """The sessions by their client's number; the shared one's is None."""
        return self._common | dict(self.seats.made.items())

    @property
    def session(self) -> Served:
        """The shared session."""
        return self._common[None]

    @property
    def page(self) -> Any:
        """The shared session's page: a `Page`, or a `ModelPage` where there is a model."""
        return self.session.page

    def stop(self) -> None:
        """End all sessions and free the port."""
        self.seats.close()
        for session in self._common.values():
            self._end(session)
        self._common = {}
        if self._keeper is not None:
            self._keeper.stop()
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

    def _share(self, left: Any, path: Path | None) -> None:
        """Make the page of all visitors; it opens as it was `left`, and is kept at `path`."""
        session = self._common[None] = self._session(self.server, self.server.get_clients)
        try:
            if left is not None:
                session.open_as_left(left)
            if path is not None:
                write_file(path, session.told(self.page.snapshot()).encode())
                self._keeper = Keeper(path, lambda why: session.post("not_kept", why))
                session.page.keep = self._keep
        except KneecoreError:
            self.stop()
            raise
        self._start(session)

    def _keep(self, state: Any) -> None:
        keeper, session = self._keeper, self.session
        assert keeper is not None
        keeper.keep(lambda: session.told(state))

    def _session(self, target: Target, clients: Clients) -> Served:
        """Return the session of a new page, not yet started."""
        session: Served
        if self._model is None:
            session = Session(target, self._knee, clients)
            if self._result is not None:
                take_result(session.page, self._result)
        else:
            session = ModelSession(target, self._model, clients)
            if self._result is not None:
                take_model_result(session.page, self._result)
        session.page.begin()
        return session

    def _start(self, session: Served) -> Served:
        session.start()
        if self.warm_up is not None:
            self.warm_up.tell(session.post)
        return session

    def _session_of(self, client: viser.ClientHandle) -> Served | None:
        if client.client_id not in self.server.get_clients():
            return None  # gone while this waited for its turn
        return self._start(self._session(client, lambda: {client.client_id: client}))

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

    def _end(self, session: Served) -> None:
        if self.warm_up is not None:
            self.warm_up.forget(session.post)
        session.stop()
