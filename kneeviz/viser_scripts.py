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
    source = _SEE_THROUGH.replace("NAMES", json.dumps(list(names)))
    viser_internals.run_script(client, source)


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
    viser_internals.run_script(client, _BLEND.replace("NAMES", json.dumps(list(names))))


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
