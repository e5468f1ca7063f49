"""The kernels' warm-up: compiled or loaded on a thread of its own before anybody needs them."""

import logging
import threading

from kneecore import Knee, SearchSettings, warm_up
from kneeviz.jobs.messages import Post

_LOG = logging.getLogger(__name__)


class KernelWarmUp:
    """Compiles or loads the kernels and tells who waits for them."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._done: list[str] = []
        self._waiting: list[Post] = []
        self._thread = threading.Thread(target=self._run, name="warm-up", daemon=True)

    def start(self) -> None:
        """Start compiling here."""
        self._thread.start()

    def tell(self, post: Post) -> None:
        """Post ("ready", what) for what is ready, now and later."""
        with self._lock:
            self._waiting.append(post)
            for what in self._done:
                post(("ready", what), None)

    def forget(self, post: Post) -> None:
        """Post no more."""
        with self._lock:
            if post in self._waiting:
                self._waiting.remove(post)

    def _announce(self, what: str) -> None:
        with self._lock:
            self._done.append(what)
            for post in self._waiting:
                post(("ready", what), None)

    def _model_ready(self) -> None:
        knee = Knee()
        knee.trajectory(knee.nominal)
        self._announce("model")

    def _run(self) -> None:
        try:
            knee = Knee()
            warm_up(knee, model_ready=self._model_ready)
            warm_up(knee, SearchSettings(search_space="model"))
            self._announce("search")
            warm_up(Knee(solver="equilibrium"), SearchSettings(method="exact"))
            self._announce("exact")
        except Exception as error:
            _LOG.exception("the kernels cannot be compiled")
            with self._lock:
                for post in self._waiting:
                    post("not_ready", error)
