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
from kneeviz import viser_broadcast, viser_internals
from kneeviz.actions.result import take_result
from kneeviz.anymodel import saved as model_saved
from kneeviz.anymodel.actions.search import take_result as take_model_result
from kneeviz.anymodel.session import ModelSession
from kneeviz.anymodel.state import of_this_model
from kneeviz.geometry import framing
from kneeviz.jobs import uploads
from kneeviz.page.page import Clients, Target
from kneeviz.server import front
from kneeviz.server.classroom import Classroom
from kneeviz.server.gate import Gate
from kneeviz.server.kept import KeptState
from kneeviz.server.kernels import KernelWarmUp
from kneeviz.server.seats import NoRoom, Seats
from kneeviz.server.session import Session
from kneeviz.state import links, results, saved
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
    link : str, optional
        What a link has after ``?knee=``: knee, bounds and settings to open with.
    for_class : bool
        Whether visitors only watch, but for the teacher, who has a token of his own, and those to
        whom he gives the wheel.

    Raises
    ------
    ParameterError
        If `result` is of another model, a knee and a model are given, or `state` is given though
        visitors have pages of their own.
    FileFormatError
        If the file of the state or the link cannot be read, or the state or `result` is none of
        `model`.
    OutputError
        If the state cannot be written, or another server writes it.
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
        link: str | None = None,
        for_class: bool = False,
    ) -> None:
        if state is not None and not shared:
            raise ParameterError("`state` is given, but each visitor has a page of his own")
        if for_class and not shared:
            raise ParameterError("`for_class` is given, but each visitor has a page of his own")
        if link is not None and (knee is not None or state is not None):
            raise ParameterError("`link` is given with `knee` or `state`, and it has a knee itself")
        self._linked = None if link is None else links.from_code(link)
        self._knee = kneecore.packaged_knee() if knee is None else knee
        for name, given in (("knee", knee), ("link", link)):
            if model is not None and given is not None:
                raise ParameterError(f"`{name}` and `model` are given; only one of them is allowed")
        self._model, self._result = model, result
        if result is not None:
            self._result = (
                results.of_knees(result) if model is None else of_this_model(model, result)
            )
        self.shared = shared
        self.gate = Gate.of(host, token=token, allowed=allow_hosts, for_class=for_class)
        self.classroom = Classroom() if for_class else None
        self._kept = None if state is None else KeptState(state, self._read_state)
        viser_internals.skip_client_build()
        viser_broadcast.install()
        viser_internals.know_array_types()
        # viser's banner is not shown: we print our own line.
        guarded = front.standing(self.gate, self.classroom)
        with contextlib.redirect_stdout(io.StringIO()), guarded:
            self.server = viser.ViserServer(host=host, port=port, label="kneeviz", verbose=False)
        viser_internals.refuse_tunnel(self.server)
        self.server.scene.world_axes.visible = False
        self._place_first_camera()
        self.warm_up = KernelWarmUp() if model is None else None
        self.seats: Seats[Served] = Seats(MAX_SESSIONS, self._end)
        self._common: dict[int | None, Served] = {}
        if shared:
            self._share()
        if self.classroom is not None:
            self.classroom.open(self.server, self.session.reject)
        self.server.on_client_connect(self._join)
        self.server.on_client_disconnect(self._leave)
        if self.warm_up is not None:
            self.warm_up.start()

    @property
    def url(self) -> str:
        """The address to open in a browser."""
        return self.gate.url(self.server.get_port())

    @property
    def class_url(self) -> str | None:
        """The address that a class is given, or None if it is no class's server."""
        return None if self.classroom is None else self.gate.class_url(self.server.get_port())

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
        if self._kept is not None:
            self._kept.stop()
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

    def _read_state(self, path: Path) -> Any:
        if self._model is None:
            return saved.read(path)
        return model_saved.read(path, self._model)

    def _share(self) -> None:
        """Make the page of all visitors."""
        try:
            session = self._common[None] = self._session(self.server, self.server.get_clients)
            if self._kept is not None:
                self._kept.follow(session)
        except KneecoreError:
            self.stop()
            raise
        self._start(session)

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
        if self._linked is not None and isinstance(session, Session):
            session.open_as_left(self._linked)
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
            viser_internals.guard(client.gui, self.session.reject)
            if self.classroom is not None:
                self.classroom.arrive(client)
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
        if self.classroom is not None:
            self.classroom.leave(client.client_id)
        if not self.shared:
            self.seats.leave(client.client_id)

    def _end(self, session: Served) -> None:
        if self.warm_up is not None:
            self.warm_up.forget(session.post)
        session.stop()
