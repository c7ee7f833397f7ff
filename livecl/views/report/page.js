"use strict";
{
  const find = (selector) => document.querySelector(selector);
  const SVG = "http://www.w3.org/2000/svg";
  const drawing = find("#drawing"), group = find("#drawing .layers"), ground = find("#drawing .ground");
  const overlay = find("#drawing .overlay"), difference = find("#difference");
  const slider = find("#slider"), play = find("#play"), facts = find("#facts"), shown = find("#shown");
  const rows = [...document.querySelectorAll("#layers tbody tr")].reverse(); // listed with the topmost first
  const thumbs = [...document.querySelectorAll(".strip a")];
  const stageRows = [...document.querySelectorAll("#stages tbody tr")];
  const dots = [...document.querySelectorAll(".plot circle")];
  const finished = { paths: [...group.children], fill: ground && ground.getAttribute("fill") };
  const finishedDifference = difference.getAttribute("src");
  const HINT = "Point at a layer, in the picture or in the list, to see what it adds; click to hold it.";

  // k: layers shown, from the bottom; stage: from 1 on, 0 for the finished drawing; lit, held: layer or -1.
  const state = { stage: 0, k: rows.length, lit: -1, held: -1, seeking: false, timer: 0 };
  let paths = finished.paths;

  const plural = (count, noun) => `${count} ${noun}${count === 1 ? "" : "s"}`;
  const clamp = (text, low, high) => Math.min(high, Math.max(low, Math.round(Number(text)) || 0));

  function load() {
    const thumb = thumbs[state.stage - 1];
    const source = thumb && thumb.querySelector("svg");
    paths = source ? [...source.querySelectorAll("path")].map((path) => path.cloneNode()) : finished.paths;
    group.replaceChildren(...paths);
    if (ground) ground.setAttribute("fill", source ? source.querySelector(".ground").getAttribute("fill") : finished.fill);
    difference.src = thumb ? thumb.dataset.difference : finishedDifference;
  }

  // Path data here is always "M x y C six numbers for each segment ... Z" with absolute numbers.
  function subpaths(path) {
    return path.getAttribute("d").split("M").slice(1).map((text) => text.match(/-?[\d.]+/g).map(Number));
  }

  function stroke(kind, d, lit) {
    const path = document.createElementNS(SVG, "path");
    path.setAttribute("class", lit ? `${kind} lit` : kind);
    path.setAttribute("d", d);
    overlay.append(path);
  }

  function drawOverlay() {
    overlay.replaceChildren();
    const count = state.stage ? paths.length : state.k;
    const chosen = paths.map((path, index) => ({ path, lit: index === state.lit }));
    const drawn = chosen.filter(({ lit }, index) => lit || (index < count && find("#outlines").checked));
    for (const kind of ["halo", "outline"]) {
      for (const { path, lit } of drawn) stroke(kind, path.getAttribute("d"), lit);
    }
    if (!find("#points").checked) return;
    for (const { path } of chosen.filter(({ lit }, index) => (state.lit < 0 ? index < count : lit))) {
      let anchors = "", handles = "", levers = "";
      for (const numbers of subpaths(path)) {
        for (let i = 0; i + 7 < numbers.length; i += 6) {
          const [ax, ay, hx, hy, gx, gy, bx, by] = numbers.slice(i, i + 8);
          anchors += `M${ax} ${ay}h0`;
          handles += `M${hx} ${hy}h0M${gx} ${gy}h0`;
          levers += `M${ax} ${ay}L${hx} ${hy}M${bx} ${by}L${gx} ${gy}`;
        }
      }
      stroke("levers", levers);
      stroke("handles", handles);
      stroke("anchors", anchors);
    }
  }

  const paintOf = (path) => path.getAttribute("stroke") || path.getAttribute("fill");

  // A gradient in a swatch has the layer's stops, and goes across the square or from its middle to its corners.
  function swatchGradient(path, square) {
    const [, id] = paintOf(path).match(/^url\(#(.*)\)$/) || [];
    if (!id) return [];
    const own = document.getElementById(id).cloneNode(true);
    const places = own.localName === "linearGradient"
      ? { x1: 0, y1: 0, x2: 1, y2: 0 } : { cx: 0.5, cy: 0.5, r: 0.707, gradientTransform: "scale(1)" };
    const attributes = { id: "swatch-lit", gradientUnits: "objectBoundingBox", ...places };
    for (const name of Object.keys(attributes)) own.setAttribute(name, attributes[name]);
    square.setAttribute("fill", "url(#swatch-lit)");
    return [own];
  }

  function describe() {
    facts.replaceChildren();
    if (state.lit < 0) return facts.append(HINT);
    const row = state.stage ? null : rows[state.lit];
    const path = paths[state.lit];
    const swatch = document.createElementNS(SVG, "svg"), square = document.createElementNS(SVG, "rect");
    swatch.setAttribute("class", "swatch");
    for (const name of ["width", "height"]) square.setAttribute(name, "100%");
    square.setAttribute("fill", paintOf(path));
    square.setAttribute("fill-opacity", path.getAttribute("fill-opacity") || path.getAttribute("stroke-opacity") || "1");
    swatch.setAttribute("aria-hidden", "true");
    swatch.append(...swatchGradient(path, square), square);
    facts.append(swatch, row ? ` ${row.dataset.facts}` : ` ${path.dataset.facts} after stage ${state.stage}`);
  }

  function show() {
    const last = thumbs.length, { stage, k } = state;
    slider.min = stage ? 1 : 0;
    slider.max = stage ? last : rows.length;
    slider.value = stage || k;
    find(`[name=mode][value=${stage ? "stages" : "layers"}]`).checked = true;
    find("#slider-label").textContent = stage ? "Stage shown" : "Layers shown";
    const text = stage
      ? `after stage ${stage} of ${last}: ${thumbs[stage - 1].dataset.facts}`
      : k === rows.length ? plural(k, "layer") : `the first ${k} of ${plural(rows.length, "layer")}`;
    slider.setAttribute("aria-valuetext", text);
    shown.textContent = `Drawing: ${text}`;
    find("#compared").textContent = stage ? `, after stage ${stage}` : k < rows.length ? ", of the whole drawing" : "";
    paths.forEach((path, index) => {
      path.style.display = stage || index < k ? "" : "none";
      path.classList.toggle("lit", index === state.lit);
    });
    drawing.classList.toggle("seeking", state.seeking && state.lit >= 0);
    rows.forEach((row, index) => {
      row.classList.toggle("beyond", !stage && index >= k);
      row.classList.toggle("lit", !stage && index === state.lit);
      row.querySelector("button").setAttribute("aria-pressed", String(!stage && index === state.held));
    });
    for (const list of [thumbs, stageRows, dots]) {
      list.forEach((item, index) => item.classList.toggle("current", index + 1 === (stage || (k === rows.length && last))));
    }
    drawOverlay();
    describe();
  }

  function address() {
    const parts = [state.stage ? `stage=${state.stage}` : `k=${state.k}`];
    for (const name of ["outlines", "points"]) if (find(`#${name}`).checked) parts.push(`${name}=1`);
    if (state.held >= 0) parts.push(`layer=${state.held}`);
    history.replaceState(null, "", `#${parts.join("&")}`);
  }

  function go(stage, k) {
    if (stage !== state.stage) Object.assign(state, { lit: -1, held: -1, seeking: false });
    const changed = stage !== state.stage;
    Object.assign(state, { stage, k });
    if (changed) load();
    show();
  }

  function light(layer, { seeking = false, hold = false } = {}) {
    if (hold) state.held = layer === state.held ? -1 : layer;
    state.lit = layer < 0 ? state.held : layer;
    state.seeking = seeking;
    show();
    if (!state.stage && state.lit >= 0 && !seeking) reveal(rows[state.lit]);
    if (hold) address();
  }

  // Scrolls the list, not the page.
  function reveal(row) {
    const list = row.closest(".scroll"), head = list.querySelector("thead").offsetHeight;
    const top = row.offsetTop - head, bottom = row.offsetTop + row.offsetHeight - list.clientHeight;
    list.scrollTop = Math.max(Math.min(list.scrollTop, top), bottom);
  }

  function read() {
    const wanted = new URLSearchParams(location.hash.slice(1));
    for (const name of ["outlines", "points"]) if (wanted.has(name)) find(`#${name}`).checked = wanted.get(name) !== "0";
    const stage = wanted.has("stage") && thumbs.length ? clamp(wanted.get("stage"), 1, thumbs.length) : 0;
    go(stage, wanted.has("k") ? clamp(wanted.get("k"), 0, rows.length) : rows.length);
    if (wanted.has("layer") && paths.length) {
      state.held = clamp(wanted.get("layer"), 0, paths.length - 1);
      light(state.held);
    }
  }

  function stop() {
    clearInterval(state.timer);
    state.timer = 0;
    play.textContent = "Play";
    play.setAttribute("aria-pressed", "false");
  }

  function move(value) {
    go(state.stage ? value : 0, state.stage ? state.k : value);
    address();
  }

  slider.addEventListener("input", () => { stop(); move(Number(slider.value)); });
  play.addEventListener("click", () => {
    if (state.timer) return stop();
    if (slider.value === slider.max) move(Number(slider.min));
    play.textContent = "Pause";
    play.setAttribute("aria-pressed", "true");
    const pause = Math.max(80, Math.min(600, 8000 / slider.max));
    state.timer = setInterval(() => (slider.value === slider.max ? stop() : move(Number(slider.value) + 1)), pause);
  });
  for (const input of document.querySelectorAll("[name=mode]")) {
    input.disabled = input.value === "stages" && !thumbs.length;
    input.addEventListener("change", () => { stop(); go(input.value === "stages" ? thumbs.length : 0, state.k); address(); });
  }
  for (const name of ["outlines", "points"]) find(`#${name}`).addEventListener("change", () => { show(); address(); });

  // Zoom: the three pictures grow in their frames, and scroll together.
  const frames = [...document.querySelectorAll(".frame")];
  find("#zoom").addEventListener("input", (event) => {
    const factor = Number(event.target.value), before = frames[0].scrollWidth;
    const centers = [frames[0].scrollLeft + frames[0].clientWidth / 2, frames[0].scrollTop + frames[0].clientHeight / 2];
    for (const frame of frames) {
      if (!frame.style.height) frame.style.height = `${frame.offsetHeight}px`;
      frame.style.setProperty("--zoom", factor);
    }
    const grown = frames[0].scrollWidth / before;
    frames[0].scrollTo(centers[0] * grown - frames[0].clientWidth / 2, centers[1] * grown - frames[0].clientHeight / 2);
    event.target.setAttribute("aria-valuetext", `${factor} times`);
  });
  for (const frame of frames) {
    frame.addEventListener("scroll", () => {
      for (const other of frames) if (other !== frame) other.scrollTo(frame.scrollLeft, frame.scrollTop);
    });
  }

  const layerAt = (event) => (event.target.closest ? paths.indexOf(event.target.closest(".layers path")) : -1);
  drawing.addEventListener("pointermove", (event) => { if (layerAt(event) !== state.lit) light(layerAt(event)); });
  drawing.addEventListener("pointerleave", () => light(-1));
  drawing.addEventListener("click", (event) => light(layerAt(event), { hold: true }));
  rows.forEach((row, index) => {
    const button = row.querySelector("button");
    const enter = () => { if (state.stage) go(0, rows.length); light(index, { seeking: true }); };
    button.tabIndex = index === rows.length - 1 ? 0 : -1;
    row.addEventListener("pointerenter", enter);
    row.addEventListener("pointerleave", () => light(-1));
    row.addEventListener("click", () => light(index, { seeking: true, hold: true }));
    button.addEventListener("focus", enter);
    button.addEventListener("blur", () => light(-1));
    button.addEventListener("keydown", (event) => {
      const next = { ArrowDown: index - 1, ArrowUp: index + 1, Home: rows.length - 1, End: 0 }[event.key];
      if (next === undefined || !rows[next]) return;
      event.preventDefault();
      button.tabIndex = -1;
      const other = rows[next].querySelector("button");
      other.tabIndex = 0;
      other.focus();
    });
  });
  document.addEventListener("keydown", (event) => {
    if (event.key !== "Escape") return;
    state.held = -1;
    light(-1);
    address();
  });
  window.addEventListener("hashchange", () => { stop(); read(); });
  find("#controls").hidden = false;
  read();
}
