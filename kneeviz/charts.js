// Values at the pointer, curves that a legend's entries switch, and a pointer that poses the knee.
// Runs in the visitor's browser alone. What is told says which charts pose the knee, and by which
// widgets.
(() => {
  window.__kneevizLook?.abort(); // of an earlier connection
  const life = (window.__kneevizLook = new AbortController());
  const { signal } = life;
  const told = TOLD;
  const hidden = (window.__kneevizHidden ??= new Set());
  const charts = () => Object.entries(window.__viserTestpoints?.uplots ?? {});

  // Curves that are switched off, and legends that say so: both are made anew now and then.
  const look = document.createElement("style");
  document.head.append(look);
  signal.addEventListener("abort", () => look.remove());
  const apply = () => {
    for (const [, { chart }] of charts()) {
      const wrong = chart.series
        .map((series, i) => [i, !hidden.has(series.key), series.show])
        .filter(([i, shown, now]) => i > 0 && shown !== now);
      if (wrong.length) chart.batch(() => wrong.forEach(([i, show]) => chart.setSeries(i, { show })));
    }
    for (const entry of document.querySelectorAll("[data-curve]")) {
      const pressed = String(!hidden.has(entry.dataset.curve));
      if (entry.getAttribute("aria-pressed") !== pressed) entry.setAttribute("aria-pressed", pressed);
    }
    const rules = [...hidden].map((key) => `[data-curve="${key}"] { text-decoration: line-through !important }`);
    if (look.textContent !== rules.join("")) look.textContent = rules.join("");
  };
  const entryOf = (event) => event.target.closest?.("[data-curve]");
  document.addEventListener("click", (event) => {
    const key = entryOf(event)?.dataset.curve;
    if (key === undefined) return;
    if (!hidden.delete(key)) hidden.add(key);
    apply();
  }, { signal });
  for (const kind of ["keydown", "keyup"])
    window.addEventListener(kind, (event) => {
      // Space presses the entry; it is also the page's key for play.
      if (entryOf(event) && [" ", "Enter"].includes(event.key)) event.stopImmediatePropagation();
    }, { signal, capture: true });

  const written = (value, { unit, digits }) => {
    const size = digits == null
      ? String(Number(Math.abs(value).toPrecision(4))) : Math.abs(value).toFixed(digits);
    const sign = value < 0 && Number(size) !== 0 ? "\u2212" : "";
    return `${sign}${size}${unit && unit !== "°" ? " " : ""}${unit ?? ""}`;
  };
  const valueAt = (places, values, place) => {
    const right = places.findIndex((one) => one >= place);
    if (right < 0) return NaN;
    if (places[right] === place || right === 0) return values[right];
    const part = (place - places[right - 1]) / (places[right] - places[right - 1]);
    return (1 - part) * values[right - 1] + part * values[right];
  };

  // The note beside the pointer.
  const note = document.createElement("div");
  note.className = "kneeviz-note";
  note.style.cssText = `position: absolute; z-index: 110; pointer-events: none; white-space: nowrap;
    font: calc(12px * var(--kneeviz-size, 1)) / 1.35 sans-serif; padding: 3px 7px;
    border-radius: 4px; border: 1px solid light-dark(#bbb, #555);
    background: light-dark(rgba(255,255,255,.9), rgba(36,36,36,.9)); color: light-dark(#222, #eaeaea)`;
  signal.addEventListener("abort", () => note.remove());
  const line = (words, colour) => {
    const row = document.createElement("div");
    if (colour === undefined) row.style.fontWeight = "600";
    else {
      const swatch = document.createElement("span");
      swatch.style.cssText = `display: inline-block; width: .8em; margin-right: .4em;
        vertical-align: middle; border-top: 3px solid ${colour}`;
      row.append(swatch);
    }
    row.append(words);
    return row;
  };
  let pointed = null; // the chart under the pointer, and where on it
  const place = ({ chart, x, y }) => chart.posToVal(chart.scales.x.ori === 1 ? y : x, "x");
  const write = () => {
    if (pointed === null) return note.remove();
    const { chart, x, y } = pointed, at = place(pointed);
    const [axis] = chart.series;
    const rows = [line(`${axis.label}: ${written(at, axis)}`)];
    chart.series.forEach((series, i) => {
      const value = i > 0 && series.unit !== undefined && series.show
        ? valueAt(chart.data[0], chart.data[i], at) : null;
      if (value === null || !Number.isFinite(value)) return;
      rows.push(line(`${series.label} ${written(value, series)}`, series.stroke(chart, i)));
    });
    note.replaceChildren(...rows);
    if (note.parentNode !== chart.over) chart.over.append(note);
    const { clientWidth: wide, clientHeight: high } = chart.over;
    note.style.left = x < wide / 2 ? `${x + 14}px` : "";
    note.style.right = x < wide / 2 ? "" : `${wide - x + 14}px`;
    note.style.top = `${Math.max(0, Math.min(y - note.offsetHeight / 2, high - note.offsetHeight))}px`;
  };

  // The pose of the knee: at most some 15 places a second, and the last one always.
  const send = (uuid, value) =>
    window.__viserMutable?.sendMessage?.({ type: "GuiUpdateMessage", uuid, updates: { value } });
  let waiting = null, timer = null, sentAt = 0, posing = false;
  const flush = () => {
    timer = null;
    sentAt = performance.now();
    posing = true;
    send(...waiting);
  };
  const pose = (widget, value) => {
    waiting = [widget, value];
    timer ??= setTimeout(flush, Math.max(0, 66 - (performance.now() - sentAt)));
  };
  const leave = () => {
    clearTimeout(timer);
    timer = null;
    if (posing) send(told.left, true);
    posing = false;
  };
  signal.addEventListener("abort", () => clearTimeout(timer));
  const go = () => { pointed = null; write(); leave(); };
  document.addEventListener("pointerdown", (event) => {
    if (pointed !== null && !pointed.chart.over.contains(event.target)) go();
  }, { signal });

  const attached = new WeakSet();
  const attach = (uuid, chart) => {
    attached.add(chart);
    const move = (event) => {
      const box = chart.over.getBoundingClientRect(), scale = chart.over.clientWidth / box.width;
      const x = (event.clientX - box.left) * scale, y = (event.clientY - box.top) * scale;
      pointed = { chart, x, y };
      write();
      if (told.poses[uuid]) pose(told.poses[uuid], place(pointed));
    };
    chart.over.addEventListener("pointermove", move, { signal });
    chart.over.addEventListener("pointerdown", move, { signal });
    chart.over.addEventListener("pointerleave", go, { signal });
    chart.over.addEventListener("pointercancel", go, { signal });
    chart.over.addEventListener("click", (event) => {
      move(event); // a finger has left before its click
      if (!told.poses[uuid]) return;
      clearTimeout(timer);
      flush();
      send(told.keep, true);
    }, { signal });
  };
  const tick = () => {
    for (const [uuid, { chart }] of charts()) if (!attached.has(chart)) attach(uuid, chart);
    if (pointed !== null && !pointed.chart.over.isConnected) go();
    apply();
    write(); // what is under the pointer may have changed
  };
  const ticking = setInterval(tick, 100);
  signal.addEventListener("abort", () => clearInterval(ticking));
})();
