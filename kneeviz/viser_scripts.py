"""What our page does in a browser beyond what viser's client does: small scripts for one client."""

import json
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path

import viser

from kneeviz import viser_internals

_WATCH_CHARTS = """(() => {
  clearInterval(window.__kneevizCharts);
  window.__kneevizCharts = setInterval(() => {
    for (const { chart } of Object.values(window.__viserTestpoints?.uplots ?? {})) {
      if (chart.width > 0 && chart.axes.some((axis) => axis.show && !axis._values?.length))
        chart.redraw(false, true);
    }
  }, 300);
})();"""


def watch_charts(client: viser.ClientHandle) -> None:
    """Let this client draw the numbers on an axis that has lost them.

    When a chart gets its size and new data in one go, uPlot's redraw forgets that the axes must be
    measured again, and an axis that was measured at width 0 stays empty.
    """
    viser_internals.run_script(client, _WATCH_CHARTS)


@cache
def _look_closer() -> str:
    return Path(__file__).with_name("charts.js").read_text(encoding="utf-8")


def look_closer(
    client: viser.ClientHandle,
    *,
    poses: Mapping[str, str] | None = None,
    left: str | None = None,
    keep: str | None = None,
) -> None:
    """Let this client tell the values at its pointer and switch curves by a legend's entries.

    Parameters
    ----------
    client : ClientHandle
    poses : mapping of str to str, optional
        The charts where the pointer poses the knee, by their id, and the ids of the numbers that
        are set to where it is.
    left, keep : str, optional
        Ids of the buttons that are pressed when it leaves such a chart, and when it is clicked.
    """
    told = json.dumps({"poses": dict(poses or {}), "left": left, "keep": keep})
    viser_internals.run_script(client, _look_closer().replace("TOLD;", f"{told};", 1))


_SEE_THROUGH = """(() => {
  clearInterval(window.__kneevizHits);
  const left = new Set(NAMES);
  window.__kneevizHits = setInterval(() => {
    for (const name of left) {
      const node = window.__viserMutable?.nodeRefFromName?.[name];
      node?.traverse((part) => {
        if (part.material?.isMeshStandardMaterial) {
          part.material.depthWrite = part.material.colorWrite = false;
          left.delete(name);
        }
      });
    }
    if (left.size === 0) clearInterval(window.__kneevizHits);
  }, 100);
})();"""


def see_through(client: viser.ClientHandle, names: Sequence[str]) -> None:
    """Let this client not draw some meshes at all, which can be hit nevertheless.

    A mesh with an opacity of 0 still hides what is drawn behind it after it.
    """
    source = _SEE_THROUGH.replace("NAMES", json.dumps(list(names)))
    viser_internals.run_script(client, source)


_NAME_WIDGETS = """(() => {
  const name = (node, text) => {
    if (node && text && !node.getAttribute("aria-label")) node.setAttribute("aria-label", text);
  };
  const all = (selector, root = document) => [...root.querySelectorAll(selector)];
  const inputs = "[role=slider], input:not([type=hidden])";
  clearInterval(window.__kneevizNames);
  window.__kneevizNames = setInterval(() => {
    document.documentElement.lang = "en";
    for (const label of all("label[for]")) {
      const widget = document.getElementById(label.htmlFor), text = label.textContent.trim();
      const row = label.closest("[class*='Flex-root']");
      for (const root of [widget, row])
        if (root) all(inputs, root).forEach((node) => name(node, text));
    }
    all(".uplot").forEach((n) => { n.setAttribute("role", "img"); name(n, "Chart: %s"); });
    all("canvas").filter((n) => !n.closest(".uplot")).forEach((n) => name(n, "%s"));
  }, 700);
})();"""


def name_widgets(client: viser.ClientHandle, chart: str, scene: str) -> None:
    """Give sliders, charts and the picture names in this client, for who hears the page.

    viser's sliders and canvases have none.
    """
    source = _NAME_WIDGETS % (chart, scene)
    viser_internals.run_script(client, source)
