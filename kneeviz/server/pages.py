"""What a server's pages are of: the knee, or a model of one's own."""

import kneecore
from kneecore import KneeFile, Model, SearchResult
from kneeviz.actions.result import take_result
from kneeviz.anymodel.actions.files import of_this_model
from kneeviz.anymodel.actions.look import camera_position
from kneeviz.anymodel.actions.search import take_result as take_model_result
from kneeviz.anymodel.frame import CENTRE
from kneeviz.anymodel.session import ModelSession
from kneeviz.page.page import Clients, Target
from kneeviz.server.kernels import KernelWarmUp
from kneeviz.server.session import Session
from kneeviz.state import results
from kneeviz.views.scene import camera

Served = Session | ModelSession
"""One page and its loop."""


class KneePages:
    """Pages of the knee.

    Parameters
    ----------
    knee : KneeFile, optional
        The baseline; the packaged one for None.
    result : SearchResult, optional
        To open with.
    kernels : KernelWarmUp, optional
        One that was started earlier.
    """

    camera = (camera.knee_position(False), camera.CENTRE)

    def __init__(
        self, knee: KneeFile | None, result: SearchResult | None, kernels: KernelWarmUp | None
    ) -> None:
        self._knee = kneecore.packaged_knee() if knee is None else knee
        self._result = None if result is None else results.of_knees(result)
        self._kernels = KernelWarmUp() if kernels is None else kernels

    def made(self, target: Target, clients: Clients) -> Session:
        """Return a new page's session, started."""
        session = Session(target, self._knee, clients)
        if self._result is not None:
            take_result(session.page, self._result)
        session.start()
        self._kernels.tell(session.post)
        return session

    def start(self) -> None:
        """Start compiling."""
        self._kernels.start()

    def end(self, session: Served) -> None:
        """End a session."""
        self._kernels.forget(session.post)
        session.stop()


class ModelPages:
    """Pages of a model of one's own.

    Parameters
    ----------
    model : Model
    result : SearchResult, optional
        To open with.
    """

    camera = (camera_position(), CENTRE)

    def __init__(self, model: Model, result: SearchResult | None) -> None:
        self._model, self._result = model, result
        if result is not None:
            self._result = of_this_model(model, result)

    def made(self, target: Target, clients: Clients) -> ModelSession:
        """Return a new page's session, started."""
        session = ModelSession(target, self._model, clients)
        if self._result is not None:
            take_model_result(session.page, self._result)
        session.start()
        return session

    def start(self) -> None:
        """Nothing is waited for by all: each page runs the model itself."""

    def end(self, session: Served) -> None:
        """End a session."""
        session.stop()


Pages = KneePages | ModelPages
"""Makes pages and ends them."""
