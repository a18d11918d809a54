// Curves of the natural frequencies along one line, each mode followed by its shape.

const BRANCH_LOOK = [
  { color: "#222222", dash: "solid" },
  { color: "#d55e00", dash: "dash" },
  { color: "#0072b2", dash: "dashdot" },
  { color: "#56b4e9", dash: "dot" },
];

function drawBranches(number) {
  const { model, unit, lines } = map.branches;
  const line = lines[number];
  const x = Array.from(decode(line.x));
  const columns = line.values.map((values) => Array.from(decode(values)));
  const scale = scaleOf(columns, "auto");
  const place = (value) => `${line.axis} = ${withUnit(format(value), line.unit)}`;
  const traces = columns.map((values, k) => ({
    type: "scatter",
    mode: x.length > 60 ? "lines" : "lines+markers",
    name: `mode ${k + 1}`,
    x,
    y: values.map((value) => (Number.isFinite(value) ? value : null)),
    line: { ...BRANCH_LOOK[k % BRANCH_LOOK.length], width: 2.2 },
    marker: { size: 5 },
    hoverinfo: "text",
    hovertext: values.map((value, i) => `mode ${k + 1}: ${withUnit(format(value), unit)}<br>${place(x[i])}`),
  }));
  const layout = baseLayout(330);
  layout.showlegend = true;
  layout.legend = LEGEND;
  layout.margin.l = 72;
  layout.xaxis = axisLayout({ name: line.axis, unit: line.unit }, { showgrid: true, gridcolor: "#eceff2" });
  layout.yaxis = axisLayout({ name: "Natural frequency", unit }, { showgrid: true, gridcolor: "#eceff2" });
  setScale(layout.yaxis, scale);
  layout.annotations = fixedNote(line.fixed, `${model} model`);
  layout.shapes = gapBands(x, Array.from(line.status, Number));
  plot("branches", traces, layout);
}

function startBranches() {
  if (!map.branches) return;
  control("branches-section").hidden = false;
  fill(control("branch-line"), map.branches.lines.map((line, i) => [String(i), line.axis]), "0");
  control("branch-line").parentElement.hidden = map.branches.lines.length < 2;
  control("branch-line").addEventListener("change", (event) => drawBranches(Number(event.target.value)));
  drawBranches(0);
}
