"""What our page does in a browser beyond what viser's client does: small scripts for one client."""

import json
from collections.abc import Sequence

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
  const FOLDERS = ".mantine-Paper-root[style*='cursor: pointer']";
  const reach = (head) => {
    const shut = head.nextElementSibling?.getAttribute("aria-hidden") === "true";
    head.setAttribute("aria-expanded", String(!shut));
    if (head.getAttribute("role") === "button") return;
    head.setAttribute("role", "button");
    head.tabIndex = 0;
    head.addEventListener("keydown", (event) => {
      if (event.key !== "Enter" && event.key !== " ") return;
      event.preventDefault();
      event.stopPropagation();
      head.click();
    });
  };
  clearInterval(window.__kneevizNames);
  window.__kneevizNames = setInterval(() => {
    document.documentElement.lang = "en";
    document.getElementById("root").setAttribute("role", "main");
    for (const [icon, text] of Object.entries(%s))
      all(`[class*="${icon}"]`).forEach((n) => name(n.closest("button"), text));
    all(FOLDERS).forEach(reach);
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


_ICONS = {
    "tabler-icon-list-search": "Commands",
    "tabler-icon-adjustments": "Connection and scene",
    "mantine-Notification-closeButton": "Close",
}
"""viser's buttons without words, by their class or their icon's, and what they are for."""


def name_widgets(client: viser.ClientHandle, chart: str, scene: str) -> None:
    """Give this client what viser's lacks for who hears the page, or has no mouse.

    Sliders, charts, pictures and icons get names, the page its main part, and the heads of folders
    a place in the order of focus.
    """
    source = _NAME_WIDGETS % (json.dumps(_ICONS), chart, scene)
    viser_internals.run_script(client, source)
