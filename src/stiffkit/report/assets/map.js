// The coloured workspace: a map with sliders, points in the plane or in space, or a curve.

const HAS_MAP = map.isGrid ? map.axes.length > 1 : map.axes.length === 2;
const HAS_VOLUME = map.isGrid ? map.axes.length > 2 : map.axes.length > 2;

function drawWorkspace(state) {
  const quantity = quantityNamed(state.quantity);
  const models = modelsShown(state.model);
  const columns = models.map((model) => valuesOf(quantity, model, state.load));
  const scale = scaleOf(columns, state.scale);
  const unit = unitOf(quantity, models[0], state.load);
  const title = label(state.model === RATIO ? "refined / simplified" : quantity.label, unit);
  const view = { state, quantity, models, columns, scale, title };
  if (HAS_MAP) drawPlane(view);
  if (HAS_VOLUME) drawVolume(view);
  if (!HAS_MAP && !HAS_VOLUME) drawCurve("map", curvesAlong(view.state, 0), view, 420);
  drawLegend(view);
}

function drawPlane(view) {
  const [first, second] = map.axes;
  const equal = first.isLength && second.isLength && comparable(first.values, second.values);
  const count = view.models.length;
  const layout = baseLayout(planeHeight(first, second, equal, count));
  layout.coloraxis = colourAxis(view.scale, view.title, view.state.model === RATIO);
  layout.annotations = [];
  const traces = [];
  view.models.forEach((model, panel) => {
    const suffix = panel ? String(panel + 1) : "";
    const domain = count > 1 ? [panel * 0.53, panel * 0.53 + 0.47] : [0, 1];
    layout[`xaxis${suffix}`] = axisLayout(first, { domain, anchor: `y${suffix}`, ...rangeOf(first), ...(equal ? { constrain: "domain" } : {}) });
    layout[`yaxis${suffix}`] = axisLayout(second, {
      anchor: `x${suffix}`,
      ...rangeOf(second),
      ...(equal ? { constrain: "domain" } : {}),
      ...(panel ? { matches: "y", title: undefined, showticklabels: false } : {}),
      ...(equal && !panel ? { scaleanchor: "x" } : {}),
    });
    if (panel) layout[`xaxis${suffix}`].matches = "x";
    const axes = { xaxis: `x${suffix}`, yaxis: `y${suffix}` };
    const made = map.isGrid ? cellTraces(view, panel) : pointTraces(view, panel);
    made.push(...markTraces(view.state));
    traces.push(...made.map((trace) => ({ ...trace, ...axes })));
    layout.annotations.push(...panelNotes(view, panel, suffix));
  });
  plot("map", traces, layout);
}

// Marks at the edge would otherwise make room for themselves.
function rangeOf({ values }) {
  const n = values.length;
  if (!map.isGrid || n < 2) return {};
  return { range: [1.5 * values[0] - 0.5 * values[1], 1.5 * values[n - 1] - 0.5 * values[n - 2]] };
}

function planeHeight(first, second, equal, count) {
  if (!equal) return 480;
  const width = document.getElementById("map").clientWidth - 170;
  return Math.min(660, Math.max(300, (width / count) * (span(second.values) / span(first.values)) + 90));
}

function span(values) {
  return Math.max(...values) - Math.min(...values);
}

function comparable(x, y) {
  const ratio = span(y) / span(x);
  return ratio > 0.2 && ratio < 5;
}

function panelNotes(view, panel, suffix) {
  const model = view.models[panel];
  const at = { xref: `x${suffix} domain`, yref: `y${suffix} domain`, showarrow: false };
  const notes = [{ ...at, x: 0, y: 1, yanchor: "bottom", xanchor: "left", yshift: 4, text: `<b>${modelName(model)}</b>` }];
  const empty = emptiness(view.columns[panel]);
  if (empty) notes.push({ ...at, x: 0.5, y: 0.5, text: empty, bgcolor: "#ffffff", borderpad: 6 });
  return notes;
}

function gapMarks(gaps, code, marker) {
  const [first, second] = map.axes;
  const every = Math.ceil(Math.max(...map.shape.slice(0, 2)) / MARKS_ALONG);
  const [x, y] = [[], []];
  gaps.forEach((row, j) => row.forEach((status, i) => {
    if (status !== code || i % every > 0 || j % every > 0) return;
    x.push(first.values[i]);
    y.push(second.values[j]);
  }));
  return { type: "scatter", mode: "markers", x, y, marker, hoverinfo: "skip" };
}

function cellTraces(view, panel) {
  const [first, second] = map.axes;
  const model = view.models[panel];
  const z = [];
  const gaps = [];
  const text = [];
  for (let j = 0; j < map.shape[1]; j += 1) {
    const rows = [[], [], []];
    for (let i = 0; i < map.shape[0]; i += 1) {
      const index = flatIndex([i, j, ...view.state.slice]);
      const status = statusOf(model, index);
      rows[0].push(toScale(view.columns[panel][index], view.scale));
      rows[1].push(status || null);
      rows[2].push(hoverText(view.quantity, view.state.load, index));
    }
    z.push(rows[0]);
    gaps.push(rows[1]);
    text.push(rows[2]);
  }
  const base = { x: first.values, y: second.values, hoverinfo: "text", hovertext: text };
  const steps = [1, 2, 3, 4].flatMap((code) => [
    [(code - 1) / 4, GAP_COLOURS[code]],
    [code / 4, GAP_COLOURS[code]],
  ]);
  const traces = [
    { ...base, type: "heatmap", z: gaps, zmin: 0.5, zmax: 4.5, colorscale: steps, showscale: false, hoverongaps: false },
    { ...base, type: "heatmap", z, coloraxis: "coloraxis", hoverongaps: false },
  ];
  for (const [code, marker] of Object.entries(GAP_MARKS)) traces.push(gapMarks(gaps, Number(code), marker));
  if (!emptiness(view.columns[panel])) {
    traces.push({
      type: "contour", x: first.values, y: second.values, z, ncontours: 9, showscale: false, hoverinfo: "skip",
      contours: { coloring: "none" }, line: { color: "rgba(0,0,0,0.5)", width: 0.8 },
    });
  }
  return traces;
}

function pointTraces(view, panel) {
  const model = view.models[panel];
  const [x, y] = map.axes.map((axis) => axis.values);
  const indices = x.map((_, i) => i);
  const texts = (chosen) => chosen.map((i) => hoverText(view.quantity, view.state.load, i));
  const pick = (values, chosen) => chosen.map((i) => values[i]);
  const traces = [];
  for (const code of [1, 2, 3, 4]) {
    const here = indices.filter((i) => statusOf(model, i) === code);
    traces.push({
      type: "scatter", mode: "markers", x: pick(x, here), y: pick(y, here), hoverinfo: "text", hovertext: texts(here),
      customdata: here, marker: { symbol: "x-thin", size: 7, line: { width: 1.5, color: GAP_COLOURS[code] } },
    });
  }
  const known = indices.filter((i) => !Number.isNaN(view.columns[panel][i]));
  traces.push({
    type: "scatter", mode: "markers", x: pick(x, known), y: pick(y, known), hoverinfo: "text", hovertext: texts(known),
    customdata: known,
    marker: {
      size: 9, coloraxis: "coloraxis", color: known.map((i) => toScale(view.columns[panel][i], view.scale)),
      line: { width: 0.5, color: "#333" },
    },
  });
  return traces;
}

// The chosen posture, if the map can show it.
function markTraces(state) {
  if (!state.chosen || !onSlice(state)) return [];
  const [x, y] = state.chosen.at;
  return [{ type: "scatter", mode: "markers", x: [x], y: [y], hoverinfo: "skip", marker: MARK }];
}

function onSlice(state) {
  if (!map.isGrid) return true;
  return state.slice.every((i, k) => nearest(map.axes[k + 2].values, state.chosen.at[k + 2]) === i);
}

function drawVolume(view) {
  const count = view.models.length;
  const layout = baseLayout(count > 1 ? 400 : 500);
  layout.margin = { l: 0, r: 0, t: 28, b: 0 };
  layout.coloraxis = colourAxis(view.scale, view.title, view.state.model === RATIO);
  layout.annotations = [];
  const traces = [];
  view.models.forEach((model, panel) => {
    const scene = panel ? `scene${panel + 1}` : "scene";
    const domain = count > 1 ? [panel * 0.5, panel * 0.5 + 0.5] : [0, 1];
    layout[scene] = sceneLayout(domain, count > 1 ? 1.6 : 1);
    layout.annotations.push({
      xref: "paper", yref: "paper", x: domain[0] + 0.02, y: 1, yanchor: "bottom", xanchor: "left", showarrow: false,
      text: `<b>${modelName(model)}</b>`,
    });
    traces.push(...spaceTraces(view, panel).map((trace) => ({ ...trace, scene })));
  });
  plot("volume", traces, layout);
}

function sceneLayout(domain, distance) {
  const eye = { x: 1.35 * distance, y: -1.65 * distance, z: 0.9 * distance };
  const scene = { domain: { x: domain, y: [0, 1] }, camera: { eye, center: { x: 0, y: 0, z: -0.12 } } };
  ["xaxis", "yaxis", "zaxis"].forEach((name, i) => {
    const axis = map.axes[i];
    scene[name] = { title: { text: label(axis.name, axis.unit) }, backgroundcolor: "#f5f6f8", gridcolor: "#dfe3e7", showbackground: true, nticks: 5 };
  });
  const lengths = map.axes.slice(0, 3).every((axis) => axis.isLength);
  const spans = map.axes.slice(0, 3).map((axis) => span(axis.values));
  scene.aspectmode = lengths && Math.min(...spans) > 0.15 * Math.max(...spans) ? "data" : "cube";
  return scene;
}

function spaceTraces(view, panel) {
  const values = view.columns[panel];
  const known = [];
  for (let i = 0; i < values.length; i += 1) {
    const where = map.isGrid ? gridIndex(i) : [];
    const shown = where.slice(3).every((index, k) => index === view.state.slice[k + 1]);
    if (shown && !Number.isNaN(values[i])) known.push(i);
  }
  const at = known.map(coordinatesOf);
  const traces = [{
    type: "scatter3d", mode: "markers", hoverinfo: "text", customdata: known,
    x: at.map((p) => p[0]), y: at.map((p) => p[1]), z: at.map((p) => p[2]),
    hovertext: known.map((i) => hoverText(view.quantity, view.state.load, i)),
    marker: {
      size: known.length > 4000 ? 2.5 : 4, coloraxis: "coloraxis",
      color: known.map((i) => toScale(values[i], view.scale)),
    },
  }];
  if (map.isGrid) traces.push(sliceOutline(view.state));
  if (view.state.chosen) {
    const [x, y, z] = view.state.chosen.at;
    traces.push({ type: "scatter3d", mode: "markers", x: [x], y: [y], z: [z], hoverinfo: "skip", marker: { ...MARK, size: 10 } });
  }
  return traces;
}

function sliceOutline(state) {
  const ends = map.axes.slice(0, 2).map((axis) => [Math.min(...axis.values), Math.max(...axis.values)]);
  const [[x0, x1], [y0, y1]] = ends;
  const height = map.axes[2].values[state.slice[0]];
  return {
    type: "scatter3d", mode: "lines", hoverinfo: "skip", line: { color: "#1c2127", width: 3 },
    x: [x0, x1, x1, x0, x0], y: [y0, y0, y1, y1, y0], z: Array(5).fill(height),
  };
}

function drawLegend(view) {
  const seen = new Set(modelsShown(view.state.model).flatMap((model) => [...map.status[model === RATIO ? map.models[0] : model]]));
  const legend = document.getElementById("legend");
  legend.replaceChildren();
  for (const code of [1, 2, 3, 4]) {
    if ((HAS_VOLUME && !HAS_MAP) || !seen.has(String(code))) continue;
    const entry = document.createElement("span");
    entry.textContent = STATUS[code];
    entry.className = `gap-${code}`;
    entry.style.setProperty("--swatch", GAP_COLOURS[code]);
    legend.append(entry);
  }
}

function plot(id, traces, layout) {
  const element = document.getElementById(id);
  element.hidden = false;
  // Keep the zoom and the view angle while only the colours change.
  layout.uirevision = "kept";
  const config = { responsive: true, displaylogo: false, toImageButtonOptions: { format: "svg" } };
  Plotly.react(element, traces, layout, { ...config, modeBarButtons: BUTTONS[map.axes.length > 1 ? id : "lines"] });
}
