"use strict";
(() => {
  const film = JSON.parse(document.getElementById("film").textContent);
  const last = film.moment.length - 1;
  const SECONDS = 5;  // from full extension to full flexion
  const TAUT = 1;     // N
  const find = (selector) => document.querySelector(selector);
  const slider = find("#position"), button = find("#play"), now = find("#now");
  const knees = film.knees.map((knee) => ({
    ...knee,
    tibiaNode: find(`.tibia.${knee.name}`),
    dotNode: find(`.dot.${knee.name}`),
    ligaments: [...document.querySelectorAll(`.lines.${knee.name} .ligament`)],
    contactNode: find(`.lines.${knee.name} .contact`),
    cell: find(`td.angle.${knee.name}`),
  }));

  const between = (rows, at) => {
    const left = Math.min(Math.floor(at), last - 1), part = at - left;
    const mix = (a, b) => Array.isArray(a) ? a.map((v, i) => mix(v, b[i])) : a + part * (b - a);
    return mix(rows[left], rows[left + 1]);
  };
  const number = (value, digits) => {
    const text = value.toFixed(digits);
    return (Number(text) === 0 ? text.replace("-", "") : text).replace("-", "\u2212");
  };

  const drawKnee = (knee, at) => {
    const [x, y] = between(knee.tibia, at), angle = between(knee.angle, at);
    knee.tibiaNode.setAttribute("transform", `translate(${x} ${y}) rotate(${angle})`);
    const [u, v] = between(knee.dot, at);
    knee.dotNode.setAttribute("transform", `translate(${u} ${v})`);
    const ends = between(knee.ends, at), tension = between(knee.tension, at);
    const width = between(knee.width, at);
    knee.ligaments.forEach((line, i) => {
      ["x1", "y1", "x2", "y2"].forEach((name, k) => line.setAttribute(name, ends[i][k]));
      line.setAttribute("stroke-width", width[i] / 2.6);
      line.classList.toggle("slack", tension[i] < TAUT);
    });
    const [cx, cy] = between(knee.contact, at);
    knee.contactNode.setAttribute("cx", cx);
    knee.contactNode.setAttribute("cy", cy);
    knee.contactNode.style.visibility = between(knee.force, at) > 0.05 ? "visible" : "hidden";
    knee.cell.textContent = `${number(angle, 1)}°`;
  };

  let share = 0, direction = 1, playing = false, before = 0;
  const draw = () => {
    const at = share * last, moment = between(film.moment, at);
    knees.forEach((knee) => drawKnee(knee, at));
    const text = `${moment > 0.005 ? "+" : ""}${number(moment, 2)} N·m`;
    now.textContent = text;
    slider.value = share;
    slider.setAttribute("aria-valuetext", text);
  };
  const step = (time) => {
    if (!playing) return;
    share += direction * Math.min(time - before, 100) / 1000 / SECONDS;
    before = time;
    if (share >= 1 || share <= 0) {
      share = Math.min(Math.max(share, 0), 1);
      direction = share === 0 ? 1 : -1;
    }
    draw();
    requestAnimationFrame(step);
  };
  const play = (wanted) => {
    playing = wanted;
    button.textContent = playing ? "Pause" : "Play";
    before = performance.now();
    if (playing) requestAnimationFrame(step);
  };

  button.addEventListener("click", () => play(!playing));
  slider.addEventListener("input", () => { play(false); share = Number(slider.value); draw(); });
  document.querySelectorAll("input[data-knee]").forEach((box) => {
    box.addEventListener("change", () => {
      document.querySelectorAll(`svg .${box.dataset.knee}`).forEach((node) => {
        node.style.display = box.checked ? "" : "none";
      });
    });
  });
  draw();
  if (!matchMedia("(prefers-reduced-motion: reduce)").matches) play(true);
})();
