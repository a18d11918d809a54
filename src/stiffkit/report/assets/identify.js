// Residuals of an identification: the nodes in space, and histograms.

const shown = JSON.parse(await unpacked("data"));
const control = (id) => document.getElementById(id);
const COMPONENT_WORDS = { all: "size", x: "along x", y: "along y", z: "along z" };
const BEFORE = "#b9bfc6";
const AFTER = "#0072b2";
const NORMAL = "#d55e00";
const treated = shown.treated !== null;

const state = { case: firstCase(), component: "all" };

// The case whose residuals have a shape is the one to look at.
function firstCase() {
  return Math.max(0, shown.cases.findIndex((one) => one.structured));
}

function residualsOf(one, component) {
  const columns = one.residuals.map(decode);
  if (component !== "all") return columns["xyz".indexOf(component)];
  return columns[0].map((x, i) => Math.hypot(x, columns[1][i], columns[2][i]));
}

function colourRange(values, component) {
  const sizes = Float64Array.from(values, Math.abs).sort();
  // A few outliers do not take the colours away from all others.
  const typical = sizes[Math.floor(0.98 * (sizes.length - 1))] || sizes[sizes.length - 1] || 1e-12;
  return component === "all" ? [0, typical] : [-typical, typical];
}

function hoverOf(one, columns) {
  const points = shown.points.map(decode);
  const out = new Set(one.outliers);
  return shown.labels.map((node, i) => {
    const at = points.map((column) => format(column[i])).join(", ");
    const parts = columns.map((column) => format(column[i])).join(", ");
    return `node ${node}${out.has(i) ? ", outlier" : ""}<br>at (${at}) mm<br>residual (${parts}) µm`;
  });
}

function drawField() {
  const one = shown.cases[state.case];
  const [x, y, z] = shown.points.map(decode);
  const values = residualsOf(one, state.component);
  const [cmin, cmax] = colourRange(values, state.component);
  const hover = { hoverinfo: "text", hovertext: hoverOf(one, one.residuals.map(decode)) };
  const size = x.length > 2000 ? 3 : 5;
  const traces = [
    {
      type: "scatter3d", mode: "markers", x, y, z, ...hover,
      marker: {
        size, color: values, cmin, cmax, line: { width: 0 },
        // Both are told from light to dark; two colours around zero are one grey.
        colorscale: state.component === "all" ? "Viridis" : "Cividis",
        colorbar: { title: { text: `residual ${COMPONENT_WORDS[state.component]} (µm)`, side: "right" }, thickness: 14, outlinewidth: 0, len: 0.85, exponentformat: "power" },
      },
    },
    {
      type: "scatter3d", mode: "markers", hoverinfo: "text", hovertext: one.outliers.map((i) => `node ${shown.labels[i]}: outlier`),
      x: one.outliers.map((i) => x[i]), y: one.outliers.map((i) => y[i]), z: one.outliers.map((i) => z[i]),
      marker: { size: size + 3, symbol: "circle-open", color: NORMAL, line: { width: 2, color: NORMAL } },
    },
    {
      type: "scatter3d", mode: "markers", hoverinfo: "text", hovertext: ["reference point"],
      x: [shown.tip[0]], y: [shown.tip[1]], z: [shown.tip[2]],
      marker: { size: 7, symbol: "cross", color: "#1c2127" },
    },
  ];
  const box = boxOf([x, y, z]);
  const axis = (name, i) => ({
    title: { text: i === box.thin ? "" : `${name} (mm)` }, range: box.ranges[i], showticklabels: i !== box.thin,
    backgroundcolor: "#ffffff", gridcolor: "#e1e5e9", zeroline: false, nticks: 5, tickangle: 0,
    // In the middle of a face's edge stands the axis's name.
    ...(box.thin < 0 ? {} : { tickvals: box.limits[i], ticktext: box.limits[i].map(format) }),
  });
  const layout = {
    ...baseLayout(430),
    margin: { l: 0, r: 0, t: 8, b: 8 },
    scene: {
      aspectmode: "manual", aspectratio: box.aspectratio, xaxis: axis("x", 0), yaxis: axis("y", 1), zaxis: axis("z", 2),
      camera: { projection: { type: "orthographic" }, eye: box.eye }, uirevision: "kept",
    },
  };
  Plotly.react("field", traces, layout, { responsive: true, displaylogo: false, modeBarButtons: BUTTONS.volume });
  const some = shown.drawn < shown.nodes ? `${shown.drawn} of ${shown.nodes} nodes: those with the largest residuals, and a sample. ` : "";
  const rings = one.outliers.length > 0 ? "Ringed nodes are outliers. " : "";
  control("field-hint").textContent = `${some}${rings}The cross is the reference point. Drag to turn, use the wheel to zoom.`;
}

// The box around the nodes, to one scale. A face is looked at along its normal, a volume from a corner.
function boxOf(columns) {
  const limits = columns.map((values) => values.reduce(([a, b], v) => [Math.min(a, v), Math.max(b, v)], [Infinity, -Infinity]));
  const longest = Math.max(...limits.map(([low, high]) => high - low));
  const room = 0.06 * longest;
  const spans = limits.map(([low, high]) => high - low + 2 * room);
  const thin = limits.findIndex(([low, high]) => high - low < 0.05 * longest);
  const eye = thin < 0 ? [1.2, 1.2, 0.8] : [0, 1, 2].map((i) => (i === thin ? 1.6 : 0.3));
  // A face fills the plot at this size, a volume seen from a corner at a smaller one.
  const size = thin < 0 ? 1.15 : 1.6;
  const [x, y, z] = spans.map((span) => (size * span) / Math.max(...spans));
  return {
    limits,
    ranges: limits.map(([low, high]) => [low - room, high + room]),
    aspectratio: { x, y, z },
    eye: { x: eye[0], y: eye[1], z: eye[2] },
    thin,
  };
}

function normalCurve(histogram, after) {
  const { reach } = histogram;
  const sigma = histogram.sigma[after];
  const width = (2 * reach) / histogram.before.length;
  const x = Array.from({ length: 201 }, (_, i) => (i / 100 - 1) * reach);
  const peak = (histogram.count[after] * width) / (sigma * Math.sqrt(2 * Math.PI));
  return { x, y: x.map((value) => peak * Math.exp(-0.5 * (value / sigma) ** 2)) };
}

function drawHistogram() {
  const histogram = shown.cases[state.case].histograms[state.component];
  const bins = histogram.before.length;
  const width = (2 * histogram.reach) / bins;
  const x = histogram.before.map((_, i) => -histogram.reach + (i + 0.5) * width);
  const bars = (y, name, color, panel) => ({
    type: "bar", x, y, name, width, marker: { color, line: { width: 0 } }, xaxis: "x", yaxis: `y${panel}`,
    hovertemplate: "%{x:.3g} µm: %{y}<extra></extra>",
  });
  const curve = (after, panel) => ({
    type: "scatter", mode: "lines", ...normalCurve(histogram, after), hoverinfo: "skip",
    line: { color: NORMAL, width: 1.8 }, xaxis: "x", yaxis: `y${panel}`,
  });
  const panels = treated ? [[0, "before", BEFORE], [1, "after", AFTER]] : [[1, "after", AFTER]];
  const traces = [];
  const layout = { ...baseLayout(430), margin: { l: 58, r: 24, t: 26, b: 46 }, bargap: 0, annotations: [] };
  layout.xaxis = axisLayout({ name: state.component === "all" ? "residual, all components" : `residual along ${state.component}`, unit: "µm" }, { range: [-histogram.reach, histogram.reach], nticks: 5, exponentformat: "power", anchor: treated ? "y2" : "y" });
  panels.forEach(([after, key, colour], i) => {
    const panel = i === 0 ? "" : String(i + 1);
    const domain = panels.length === 1 ? [0, 1] : [[0.55, 1], [0, 0.45]][i];
    traces.push(bars(histogram[key], key, colour, panel), curve(after, panel));
    layout[`yaxis${panel}`] = axisLayout({ name: "count", unit: "" }, { domain, rangemode: "tozero" });
    const words = { before: "all nodes", after: treated ? (shown.treated === "robust" ? "robust fit, without outliers" : "without outliers") : "all nodes" }[key];
    layout.annotations.push({ xref: "x domain", yref: `y${panel} domain`, x: 0, y: 1, xanchor: "left", yanchor: "bottom", yshift: 3, showarrow: false, text: `<b>${words}</b>, sigma ${format(histogram.sigma[after])} µm` });
  });
  Plotly.react("histogram", traces, layout, { responsive: true, displaylogo: false, modeBarButtons: BUTTONS.lines });
  const beyond = histogram.beyond > 0 ? ` ${histogram.beyond} residuals lie beyond the ends.` : "";
  control("histogram-hint").textContent = `The line is the normal distribution with this sigma.${beyond}`;
}

function draw() {
  const one = shown.cases[state.case];
  drawField();
  drawHistogram();
  control("verdict").textContent = `Load case ${one.name}: ${one.words}.`;
}

function fill(select, options, chosen) {
  select.replaceChildren(...options.map(([value, text]) => new Option(text, value, false, value === chosen)));
}

function start() {
  fill(control("case"), shown.cases.map((one, j) => [String(j), one.name]), String(state.case));
  fill(control("component"), [["all", "size, all components"], ["x", "along x"], ["y", "along y"], ["z", "along z"]], "all");
  control("case").addEventListener("change", (event) => { state.case = Number(event.target.value); draw(); });
  control("component").addEventListener("change", (event) => { state.component = event.target.value; draw(); });
  control("units").addEventListener("change", (event) => {
    control("compliance-mm").hidden = event.target.value !== "mm";
    control("compliance-si").hidden = event.target.value !== "si";
  });
  draw();
  fitToPaperInPrint();
}

start();
