"""How a model's page looks: cameras and charts. Runs on the session's worker."""

import time
from collections.abc import Callable
from typing import Any

from kneeviz import viser_scripts
from kneeviz.anymodel.page import ModelPage
from kneeviz.jobs.messages import Asked


def _joined(page: ModelPage, _value: Any, client_id: int) -> None:
    client = page.clients().get(client_id)
    if client is not None:
        page.framing.join(client, page.subject, time.monotonic())
        viser_scripts.watch_charts(client)
        viser_scripts.look_closer(client)
        viser_scripts.name_widgets(client, "the model's outputs", "The model's picture")


def _resized(page: ModelPage, _value: Any, client_id: int) -> None:
    page.framing.resize(client_id, time.monotonic())


def _reset_view(page: ModelPage, value: Asked) -> None:
    page.frame = None
    page.draw()
    page.framing.reset(page.subject, time.monotonic(), only=value.client_id)


def _chart(page: ModelPage, _value: Any) -> None:
    page.view.charts.show_chosen()
    page.touched = True


ACTIONS: dict[str, Callable[..., None]] = {
    "joined": _joined,
    "resized": _resized,
    "reset_view": _reset_view,
    "chart": _chart,
}
