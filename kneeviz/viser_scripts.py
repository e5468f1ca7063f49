"""What our page does in a browser beyond what viser's client does: small scripts for one client."""

import json
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

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


_TELL_LINK = """(() => {
  const code = new URLSearchParams(location.search).get("knee");
  if (code !== null && window.__kneevizLink !== code) {
    if (ONCE) window.__kneevizLink = code;
    const updates = { value: code.slice(0, MOST) };
    window.__viserMutable.sendMessage({ type: "GuiUpdateMessage", uuid: UUID, updates });
  }
  clearInterval(window.__kneevizLinks);
  window.__kneevizLinks = setInterval(() => {
    for (const link of document.querySelectorAll("a[data-knee]"))
      if (link.textContent !== link.href) link.textContent = link.href;
  }, 300);
})();"""


def tell_link(client: viser.ClientHandle, text: Any, *, once: bool) -> None:
    """Let this client set a widget, `text`, to what its address has after ``?knee=``.

    viser's client keeps the query of its address to itself. With `once` a page that has lost its
    connection and is back does not tell it again. Links on the page show their whole address.
    """
    uuid, most = viser_internals.widget_id(text), viser_internals.MAX_TEXT
    source = _filled(_TELL_LINK, {"UUID": uuid, "ONCE": once, "MOST": most})
    viser_internals.run_script(client, source)


_COPY = """(() => {
  const text = new URL(QUERY, location.href).href;
  const byHand = () => {
    const area = document.createElement("textarea");
    area.value = text;
    document.body.append(area);
    area.select();
    document.execCommand("copy");
    area.remove();
  };
  // Pages that are not from this machine, and not encrypted, have no clipboard.
  if (navigator.clipboard) navigator.clipboard.writeText(text).catch(byHand);
  else byHand();
})();"""


def copy_address(client: viser.ClientHandle, query: str) -> None:
    """Put this client's address with another query into its clipboard."""
    viser_internals.run_script(client, _COPY.replace("QUERY", json.dumps(query)))


_HIDE_TOKEN = """(() => {
  const address = new URL(location.href);
  address.searchParams.delete("token");
  history.replaceState(null, "", address);
})();"""


def hide_token(client: viser.ClientHandle) -> None:
    """Take the token out of this client's address, which a class may see on the wall."""
    viser_internals.run_script(client, _HIDE_TOKEN)


_ROLE = """(() => {
  const line = LINE, watches = WATCHES, id = "kneeviz-role";
  document.getElementById(id)?.remove();
  document.getElementById(id + "-style")?.remove();
  if (line === null) return;
  const said = document.createElement("div");
  said.id = id;
  said.setAttribute("role", "status");
  said.textContent = line;
  const style = document.createElement("style");
  style.id = id + "-style";
  style.textContent = SAID + (watches ? WIDGETS : "");
  document.body.append(said);
  document.head.append(style);
})();"""
_SAID = (
    "#kneeviz-role{position:fixed;bottom:12px;left:50%;transform:translateX(-50%);z-index:500;"
    "max-width:90vw;padding:6px 14px;border-radius:16px;pointer-events:none;background:#222;"
    "color:#fff;font:600 15px sans-serif;text-align:center}"
    "@media(max-width:770px){#kneeviz-role{bottom:auto;top:12px}}"  # the panel is below there
)
_WATCHED = (
    ".mantine-Slider-root,.mantine-Button-root,.mantine-Input-wrapper,.mantine-Checkbox-root,"
    ".mantine-InputWrapper-root{opacity:.45;pointer-events:none}"
)
"""The widgets of a page that is only watched; charts, tabs and folders stay alive."""


def show_role(client: viser.ClientHandle, line: str | None, *, drives: bool) -> None:
    """Tell a member of a class what he may do, in a line over his page, or nothing.

    If he does not drive, his widgets look so.
    """
    values = {"LINE": line, "WATCHES": not drives, "SAID": _SAID, "WIDGETS": _WATCHED}
    viser_internals.run_script(client, _filled(_ROLE, values))


def _filled(source: str, values: Mapping[str, Any]) -> str:
    """Return a script with values in the places of their names."""
    for name, value in values.items():
        source = source.replace(name, json.dumps(value))
    return source
