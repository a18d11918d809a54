// Curves of the chosen quantity along one coordinate, both models.

// Indices of the postures along an axis through the given grid index, and what stays fixed.
function curvesAlong(state, axis) {
  if (!map.isGrid) return { axis: map.axes[0], indices: sortedPoints(), fixed: "" };
  const centre = state.through === "selected" && state.chosen ? cellOf(state.chosen) : map.middle;
  const indices = map.axes[axis].values.map((_, i) => flatIndex(centre.map((c, k) => (k === axis ? i : c))));
  const fixed = map.axes
    .map((other, k) => ({ other, value: other.values[centre[k]], k }))
    .filter(({ k }) => k !== axis)
    .map(({ other, value }) => `${other.name} = ${withUnit(format(value), other.unit)}`)
    .join(", ");
  return { axis: map.axes[axis], indices, fixed };
}

function sortedPoints() {
  const values = map.axes[0].values;
  return values.map((_, i) => i).sort((a, b) => values[a] - values[b]);
}

function cellOf(chosen) {
  return map.axes.map((axis, k) => nearest(axis.values, chosen.at[k]));
}

function drawLines(state) {
  const quantity = quantityNamed(state.quantity);
  const models = state.model === RATIO ? [RATIO] : map.models;
  const columns = models.map((model) => valuesOf(quantity, model, state.load));
  const title = label(
    state.model === RATIO ? "refined / simplified" : quantity.label,
    unitOf(quantity, models[0], state.load),
  );
  const view = { state, quantity, models, columns, title };
  drawCurve("lines", curvesAlong(state, state.lineAxis), view, 330);
}

function drawCurve(id, along, view, height) {
  const { state, quantity, models } = view;
  const shown = models.map((_, k) => along.indices.map((i) => view.columns[k][i]));
  const scale = scaleOf(shown, state.scale);
  const x = along.indices.map((i) => (map.isGrid ? along.axis.values[gridIndex(i)[map.axes.indexOf(along.axis)]] : along.axis.values[i]));
  const traces = models.map((model, k) => ({
    type: "scatter",
    mode: x.length > 60 ? "lines" : "lines+markers",
    name: emptiness(shown[k]) === "rigid in this model" ? `${model}: rigid` : modelName(model),
    x,
    y: shown[k].map((value) => (Number.isFinite(value) && !(scale.log && value <= 0) ? value : null)),
    line: { ...LINE_LOOK[model], width: 2.2 },
    marker: { size: 5 },
    hoverinfo: "text",
    hovertext: along.indices.map((i) => hoverText(quantity, state.load, i)),
    customdata: along.indices,
  }));
  const layout = baseLayout(height);
  layout.showlegend = true;
  layout.legend = LEGEND;
  layout.margin.l = 72;
  layout.xaxis = axisLayout(along.axis, { showgrid: true, gridcolor: "#eceff2" });
  layout.yaxis = axisLayout({ name: view.title, unit: "" }, { showgrid: true, gridcolor: "#eceff2" });
  setScale(layout.yaxis, scale);
  if (!scale.log) layout.yaxis.rangemode = "tozero";
  layout.annotations = fixedNote(along.fixed);
  layout.shapes = gapShapes(x, along.indices, models);
  if (state.chosen && (state.through === "selected" || !map.isGrid || map.axes.length === 1)) {
    const at = state.chosen.at[map.axes.indexOf(along.axis)];
    layout.shapes.push({ type: "line", xref: "x", yref: "paper", x0: at, x1: at, y0: 0, y1: 1, line: { color: MARK.color, width: 1.5, dash: "dot" } });
  }
  plot(id, traces, layout);
}

// Round ticks on a logarithmic axis; a linear one fits itself to the values.
function setScale(axis, scale) {
  if (!scale.log) return;
  const ticks = logTicks(scale);
  const margin = 0.06 * Math.log10(scale.high / scale.low);
  const range = [Math.log10(scale.low) - margin, Math.log10(scale.high) + margin];
  Object.assign(axis, { type: "log", range, tickvals: ticks, ticktext: ticks.map(format) });
}

// What stays the same along a line, above the plot.
function fixedNote(fixed, model) {
  const text = [fixed && `at ${fixed}`, model].filter(Boolean).join(", ");
  return text ? [{ xref: "paper", yref: "paper", x: 0, y: 1.01, yanchor: "bottom", showarrow: false, text }] : [];
}

// Grey bands where no model has an answer.
function gapShapes(x, indices, models) {
  const codes = indices.map((index) => {
    const all = models.map((model) => statusOf(model, index));
    return all.some((code) => code === 0) ? 0 : all[0];
  });
  return gapBands(x, codes);
}

// Grey bands at postures without an answer, out to half way to the neighbours.
function gapBands(x, codes) {
  const shapes = [];
  codes.forEach((code, i) => {
    if (code === 0 || code === 4) return;
    const left = i > 0 ? (x[i - 1] + x[i]) / 2 : x[i];
    const right = i + 1 < x.length ? (x[i] + x[i + 1]) / 2 : x[i];
    shapes.push({
      type: "rect", xref: "x", yref: "paper", x0: left, x1: right, y0: 0, y1: 1,
      fillcolor: GAP_COLOURS[code], opacity: 0.7, line: { width: 0 }, layer: "below",
    });
  });
  return shapes;
}
