"""What our page does in a browser beyond what viser's client does: small scripts for one client."""

import json
import re
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


_CHARTS = """(() => {
  if (window.__kneevizCanvas) return;
  const own = window.__kneevizCanvas = HTMLCanvasElement.prototype.getContext;
  HTMLCanvasElement.prototype.getContext = function (kind, options) {
    const wanted = kind === "2d" ? { willReadFrequently: true, ...options } : options;
    return own.call(this, kind, wanted);
  };
  const pen = CanvasRenderingContext2D.prototype, write = pen.fillText;
  pen.fillText = function (text, ...at) {
    return write.call(this, String(text).replace(/^-(?=[0-9])/, "\u2212"), ...at);
  };
})();"""


def prepare_charts(server: viser.ViserServer) -> None:
    """Let browsers draw charts by the CPU, with true minus signs; call it before there are any.

    Sixty thin lines are nothing to draw, but a graphics card that is none (software rendering)
    takes as long for them as for a frame of the knee.
    """
    viser_internals.run_script_first(server, _CHARTS)


_FRAMES_ON_DEMAND = """(() => {
  clearInterval(window.__kneevizFrames);
  window.__kneevizFrames = setInterval(() => {
    const mutable = window.__viserMutable;
    const root = mutable?.scene?.__r3f?.root;
    if (!root || !mutable.cameraControl) return;
    clearInterval(window.__kneevizFrames);
    const draw = () => root.getState().invalidate();
    let last;
    mutable.requestRender = () => {
      clearTimeout(last);
      last = setTimeout(draw, 250);
      const dragging = !mutable.cameraControl.enabled && window.event?.type === "pointermove";
      if (!dragging) draw();
    };
  }, 50);
})();"""


def draw_frames_on_demand(client: viser.ClientHandle) -> None:
    """Let this client draw a frame when there is news, and one more when it has settled.

    viser draws on for a quarter of a second, and at once when the hand moves what it drags, though
    the answer is yet to come. With software rendering, the answer then waits for frames that show
    nothing new.
    """
    viser_internals.run_script(client, _FRAMES_ON_DEMAND)


_HINTS = """(() => {
  if (window.__kneevizHint) return;
  const hint = window.__kneevizHint = document.createElement("div");
  hint.setAttribute("role", "tooltip");
  hint.style.cssText = "position:fixed;z-index:50;pointer-events:none;display:none;"
    + "white-space:pre;padding:4px 8px;border-radius:4px;box-shadow:0 1px 4px #0006;"
    + "color:light-dark(#222,#eaeaea);background:light-dark(#fff,#242424)";
  document.body.append(hint);
  const pixels = (place, { camera, canvas }) => {
    const at = place.project(camera), box = canvas.getBoundingClientRect();
    return [box.left + (at.x + 1) / 2 * box.width, box.top + (1 - at.y) / 2 * box.height];
  };
  const distance = (name, reach, event, mutable) => {
    const node = mutable.nodeRefFromName[`/handles/${name}`];
    if (!node?.children[0]) return Infinity;
    const middle = node.position.clone().setFromMatrixPosition(node.children[0].matrixWorld);
    const right = middle.clone().setFromMatrixColumn(mutable.camera.matrixWorld, 0);
    const edge = pixels(right.multiplyScalar(reach).add(middle), mutable);
    const [x, y] = pixels(middle, mutable);
    const away = Math.hypot(event.clientX - x, event.clientY - y);
    return away <= Math.hypot(edge[0] - x, edge[1] - y) ? away : Infinity;
  };
  const told = (event) => {
    const mutable = window.__viserMutable, said = document.getElementById("kneeviz-handles");
    if (!said || event.target !== mutable?.canvas || event.buttons) return;
    if (event.pointerType !== "mouse" || !mutable.nodeRefFromName["/handles"]?.visible) return;
    const { reach, size, texts } = JSON.parse(said.dataset.texts);
    hint.style.font = `${size}px sans-serif`;
    const found = Object.keys(texts).map((n) => [distance(n, reach, event, mutable), texts[n]]);
    const [near, text] = found.sort((a, b) => a[0] - b[0])[0] ?? [Infinity];
    return near < Infinity ? text : undefined;
  };
  addEventListener("pointermove", (event) => {
    const text = told(event);
    hint.style.display = text ? "block" : "none";
    if (!text) return;
    hint.textContent = text;
    hint.style.left = `${event.clientX + 16}px`;
    hint.style.top = `${event.clientY + 16}px`;
  });
  addEventListener("pointerdown", () => { hint.style.display = "none"; }, true);
})();"""


def tell_handles(client: viser.ClientHandle) -> None:
    """Let this client say, beside a mouse over a handle, what `views.html.hints` has written."""
    viser_internals.run_script(client, _HINTS)


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
    told = {"poses": dict(poses or {}), "left": left, "keep": keep}
    viser_internals.run_script(client, _filled(_look_closer(), {"TOLD": told}))


_SEE_THROUGH = """(() => {
  clearInterval(window.__kneevizHits);
  const left = new Set(NAMES);
  window.__kneevizHits = setInterval(() => {
    for (const name of left) {
      const node = window.__viserMutable?.nodeRefFromName?.[name];
      node?.traverse((part) => {
        if (part.material?.isMeshStandardMaterial) {
          part.material.visible = false;
          left.delete(name);
        }
      });
    }
    if (left.size === 0) clearInterval(window.__kneevizHits);
  }, 100);
})();"""


def see_through(client: viser.ClientHandle, names: Sequence[str]) -> None:
    """Let this client not draw some meshes at all, which can be hit nevertheless.

    A mesh with an opacity of 0 takes time, and hides what is drawn behind it after it.
    """
    viser_internals.run_script(client, _filled(_SEE_THROUGH, {"NAMES": list(names)}))


_BLEND = """(() => {
  clearInterval(window.__kneevizBlend);
  window.__kneevizBlend = setInterval(() => {
    for (const name of NAMES) {
      window.__viserMutable?.nodeRefFromName?.[name]?.traverse(({ material }) => {
        if (!material?.isMeshStandardMaterial || material.depthWrite !== material.transparent)
          return;
        material.depthWrite = !material.transparent;
        window.__viserMutable.requestRender();
      });
    }
  }, 200);
})();"""


def blend(client: viser.ClientHandle, names: Sequence[str]) -> None:
    """Let this client see through meshes, while they are translucent, to all that is behind them.

    Translucent bodies that cross would cut patches out of each other: each hides what is drawn
    after it and is behind.
    """
    viser_internals.run_script(client, _filled(_BLEND, {"NAMES": list(names)}))


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
    for (const [icon, text] of Object.entries(ICONS))
      all(`[class*="${icon}"]`).forEach((n) => name(n.closest("button"), text));
    all(FOLDERS).forEach(reach);
    for (const label of all("label[for]")) {
      const widget = document.getElementById(label.htmlFor), text = label.textContent.trim();
      const row = label.closest("[class*='Flex-root']");
      for (const root of [widget, row])
        if (root) all(inputs, root).forEach((node) => name(node, text));
    }
    all("[role=progressbar]").forEach((n) => name(n, "Progress"));
    all(".uplot").forEach((n) => { n.setAttribute("role", "img"); name(n, CHART); });
    all("canvas").filter((n) => !n.closest(".uplot")).forEach((n) => name(n, SCENE));
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
    values = {"ICONS": _ICONS, "CHART": f"Chart: {chart}", "SCENE": scene}
    viser_internals.run_script(client, _filled(_NAME_WIDGETS, values))


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
    viser_internals.run_script(client, _filled(_COPY, {"QUERY": query}))


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
    """Return a script with values in the places of their names, each a word of its own."""
    names = re.compile(rf"\b({'|'.join(values)})\b")
    return names.sub(lambda found: json.dumps(values[found[1]]), source)
