// The mechanism at rest and as a mode moves it, on a canvas that can be turned.

const data = JSON.parse(await unpacked("data"));
const byId = (id) => document.getElementById(id);
const canvas = byId("shape");
const pen = canvas.getContext("2d");

const PERIOD = 1600; // ms, of every mode: real ones are too fast to see
const REST = "#b3b9c0";
const INK = "#1c2127";
const LINK = "#0072b2";
const DRIVE = "#d55e00";
const HALF_TURN = Math.PI;

const VIEWS = {
  space: ["oblique", -58, 24],
  xy: ["onto x, y", -90, 90],
  xz: ["onto x, z", -90, 0],
  yz: ["onto y, z", 0, 0],
};

const still = window.matchMedia("(prefers-reduced-motion: reduce)").matches;
const state = { mode: 0, playing: !still, phase: 1, amplitude: Number(byId("amplitude").value) / 100, azimuth: 0, elevation: 0, zoom: 1 };

// Geometry.

function rotation() {
  const [ca, sa] = [Math.cos(state.azimuth), Math.sin(state.azimuth)];
  const [ce, se] = [Math.cos(state.elevation), Math.sin(state.elevation)];
  // Rows: to the right, up, and towards the viewer.
  return [[-sa, ca, 0], [-ca * se, -sa * se, ce], [ca * ce, sa * ce, se]];
}

function projection() {
  const [right, up] = rotation();
  const middle = data.low.map((low, i) => (low + data.high[i]) / 2);
  const room = 0.95 * data.size;
  const scale = (state.zoom * Math.min(canvas.clientWidth, 1.25 * canvas.clientHeight)) / room;
  const dot = (a, p) => a[0] * (p[0] - middle[0]) + a[1] * (p[1] - middle[1]) + a[2] * (p[2] - middle[2]);
  return (p) => [canvas.clientWidth / 2 + scale * dot(right, p), canvas.clientHeight / 2 - scale * dot(up, p)];
}

function bent(points, moved, share) {
  const factor = (share * state.amplitude) / data.shown;
  return points.map((p, i) => p.map((x, k) => x + factor * moved[i][k]));
}

// Drawing.

function line(project, points, colour, width, dash = []) {
  pen.beginPath();
  points.forEach((p, i) => pen[i ? "lineTo" : "moveTo"](...project(p)));
  pen.strokeStyle = colour;
  pen.lineWidth = width;
  pen.setLineDash(dash);
  pen.stroke();
  pen.setLineDash([]);
}

function mechanism(project, share, look) {
  for (const part of data.lines) {
    const colour = look.colour ?? { elastic: LINK, rigid: INK, guide: REST }[part.kind];
    const width = part.kind === "elastic" ? look.width : 0.7 * look.width;
    if (part.kind === "guide") line(project, bent(part.rest, part.moved[state.mode], share), "#c9ced3", 1, [2, 4]);
    else line(project, bent(part.rest, part.moved[state.mode], share), colour, width);
  }
}

function joint(project, mark, share) {
  const [at] = bent([mark.at], [mark.moved[state.mode]], share);
  const [x, y] = project(at);
  pen.beginPath();
  if (mark.grounded) pen.rect(x - 5, y - 5, 10, 10);
  else pen.arc(x, y, 4.5, 0, 2 * HALF_TURN);
  pen.fillStyle = mark.driven ? DRIVE : "#ffffff";
  pen.strokeStyle = mark.driven ? DRIVE : INK;
  pen.lineWidth = 1.4;
  pen.fill();
  pen.stroke();
}

function tool(project, share) {
  const [at] = bent([data.tool.at], [data.tool.moved[state.mode]], share);
  const [x, y] = project(at);
  pen.beginPath();
  for (let i = 0; i < 10; i += 1) {
    const r = i % 2 ? 4.2 : 10;
    const angle = (i * HALF_TURN) / 5 - HALF_TURN / 2;
    pen.lineTo(x + r * Math.cos(angle), y + r * Math.sin(angle));
  }
  pen.closePath();
  pen.fillStyle = INK;
  pen.fill();
  pen.strokeStyle = "#ffffff";
  pen.lineWidth = 1;
  pen.stroke();
}

function triad() {
  const [right, up, towards] = rotation();
  const [x, y, size] = [52, canvas.clientHeight - 48, 30];
  pen.font = "13px system-ui, sans-serif";
  pen.textAlign = "center";
  pen.textBaseline = "middle";
  ["x", "y", "z"].forEach((name, i) => {
    const [dx, dy] = [size * right[i], -size * up[i]];
    if (Math.abs(towards[i]) > 0.995) return;
    pen.beginPath();
    pen.moveTo(x, y);
    pen.lineTo(x + dx, y + dy);
    pen.strokeStyle = "#7d868f";
    pen.lineWidth = 1.4;
    pen.stroke();
    pen.fillStyle = "#5c6670";
    pen.fillText(name, x + 1.35 * dx, y + 1.35 * dy);
  });
}

function legend() {
  const entries = [["at rest", REST], ["elastic link", LINK]];
  if (data.lines.some((part) => part.kind === "rigid")) entries.push(["rigid link", INK]);
  if (data.joints.some((mark) => mark.driven)) entries.push(["drive", DRIVE]);
  pen.font = "12px system-ui, sans-serif";
  pen.textAlign = "left";
  pen.textBaseline = "middle";
  entries.forEach(([name, colour], i) => {
    const y = 20 + 19 * i;
    pen.fillStyle = colour;
    if (name === "drive") pen.fillRect(24, y - 5, 10, 10);
    else pen.fillRect(16, y - 1.5, 26, 3);
    pen.fillStyle = "#5c6670";
    pen.fillText(name, 50, y);
  });
}

function draw() {
  const ratio = window.devicePixelRatio || 1;
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  if (canvas.width !== Math.round(ratio * width) || canvas.height !== Math.round(ratio * height)) {
    canvas.width = Math.round(ratio * width);
    canvas.height = Math.round(ratio * height);
  }
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  pen.lineCap = pen.lineJoin = "round";
  const project = projection();
  for (const outline of data.base) line(project, outline, "#c9ced3", 1, [2, 4]);
  mechanism(project, 0, { colour: REST, width: 2 });
  mechanism(project, state.phase, { width: 4 });
  for (const mark of data.joints) joint(project, mark, state.phase);
  tool(project, state.phase);
  triad();
  legend();
}

// Time.

let before = null;
let angle = HALF_TURN / 2;

function tick(now) {
  if (!state.playing) {
    before = null;
    return;
  }
  if (before !== null) angle += (2 * HALF_TURN * (now - before)) / PERIOD;
  before = now;
  state.phase = Math.sin(angle);
  draw();
  requestAnimationFrame(tick);
}

function play(playing) {
  state.playing = playing;
  byId("play").textContent = playing ? "Pause" : "Play";
  if (playing) requestAnimationFrame(tick);
}

// Controls.

function element(tag, text, attributes = {}) {
  const made = document.createElement(tag);
  if (text !== undefined) made.textContent = text;
  Object.entries(attributes).forEach(([name, value]) => made.setAttribute(name, value));
  return made;
}

function listModes() {
  byId("modes").replaceChildren(...data.modes.map((mode, i) => {
    const button = element("button", undefined, { type: "button" });
    button.append(element("strong", `Mode ${i + 1}: ${mode.frequency} Hz`), element("span", mode.words));
    button.addEventListener("click", () => choose(i));
    const cell = element("td");
    cell.append(button);
    const row = element("tr");
    row.append(cell);
    return row;
  }));
}

function listEnergy(mode) {
  byId("energy").replaceChildren(...mode.energy.map(([name, share]) => {
    const row = element("div", undefined, { class: "share" });
    const track = element("div", undefined, { class: "track" });
    const bar = element("div");
    bar.style.width = `${100 * share}%`;
    track.append(bar);
    row.append(element("span", name), track, element("span", `${(100 * share).toFixed(share < 0.1 ? 1 : 0)} %`));
    return row;
  }));
}

function choose(i) {
  state.mode = i;
  const mode = data.modes[i];
  byId("shape-heading").textContent = `Mode ${i + 1}: ${mode.frequency} Hz`;
  document.querySelectorAll("#modes button").forEach((button, k) => button.setAttribute("aria-pressed", String(k === i)));
  listEnergy(mode);
  look(mode.view);
}

function look(view) {
  const [, azimuth, elevation] = VIEWS[view];
  state.azimuth = (azimuth * HALF_TURN) / 180;
  state.elevation = (elevation * HALF_TURN) / 180;
  byId("view").value = view;
  draw();
}

function turn(dx, dy) {
  state.azimuth -= dx;
  state.elevation = Math.max(-HALF_TURN / 2, Math.min(HALF_TURN / 2, state.elevation + dy));
  byId("view").value = "space";
  draw();
}

byId("view").replaceChildren(...Object.entries(VIEWS).map(([name, [text]]) => new Option(text, name)));
byId("view").addEventListener("change", (event) => look(event.target.value));
byId("play").addEventListener("click", () => play(!state.playing));
const amplitudeText = () => { byId("amplitude-text").textContent = `${byId("amplitude").value} %`; };
byId("amplitude").addEventListener("input", () => {
  state.amplitude = Number(byId("amplitude").value) / 100;
  amplitudeText();
  draw();
});
canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
canvas.addEventListener("pointermove", (event) => {
  if (canvas.hasPointerCapture(event.pointerId)) turn(event.movementX / 150, event.movementY / 150);
});
canvas.addEventListener("wheel", (event) => {
  event.preventDefault();
  state.zoom = Math.max(0.3, Math.min(6, state.zoom * Math.exp(-event.deltaY / 600)));
  draw();
}, { passive: false });
canvas.addEventListener("keydown", (event) => {
  const step = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] }[event.key];
  if (!step) return;
  event.preventDefault();
  turn(...step);
});
new ResizeObserver(draw).observe(canvas);

amplitudeText();
listModes();
choose(0);
play(state.playing);
