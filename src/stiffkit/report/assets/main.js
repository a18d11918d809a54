// The controls, and what happens when one of them changes.

const state = {
  quantity: map.first,
  load: map.loads[0] ?? "",
  // Curves of both models fit into one plot; maps do not.
  model: map.axes.length === 1 && map.models.length === 2 ? BOTH : map.models[0],
  scale: "auto",
  slice: map.isGrid ? map.middle.slice(2) : [],
  lineAxis: 0,
  through: "middle",
  chosen: null,
};
const control = (id) => document.getElementById(id);

function fill(select, options, chosen) {
  select.replaceChildren(...options.map(([value, text]) => new Option(text, value, false, value === chosen)));
}

function draw() {
  control("load-control").hidden = !quantityNamed(state.quantity).perLoad;
  drawWorkspace(state);
  if (map.isGrid && map.axes.length > 1) drawLines(state);
  drawWorst(state, choose);
  drawPosture(state);
}

function choose(posture) {
  state.chosen = posture;
  control("line-through").querySelector('[value="selected"]').disabled = false;
  if (map.isGrid) {
    state.slice = cellOf(posture).slice(2);
    control("sliders").querySelectorAll("input").forEach((slider, k) => {
      slider.value = state.slice[k];
      slider.nextElementSibling.textContent = sliceText(k);
    });
  }
  draw();
}

function sliceText(k) {
  const axis = map.axes[k + 2];
  return `${axis.name} = ${withUnit(format(axis.values[state.slice[k]]), axis.unit)}`;
}

function makeSliders() {
  state.slice.forEach((index, k) => {
    const slider = element("input", undefined, { type: "range", min: 0, max: map.shape[k + 2] - 1, step: 1, value: index });
    const output = element("output", sliceText(k));
    slider.addEventListener("input", () => {
      state.slice[k] = Number(slider.value);
      output.textContent = sliceText(k);
      drawWorkspace(state);
    });
    const row = element("label", `Slice at ${map.axes[k + 2].name}`);
    row.append(slider, output);
    control("sliders").append(row);
  });
}

function watch(id, name, convert = (value) => value) {
  control(id).addEventListener("change", (event) => {
    state[name] = convert(event.target.value);
    draw();
  });
}

function chooseOnClick(id) {
  control(id).on?.("plotly_click", ({ points }) => {
    const point = points[0];
    if (typeof point.customdata === "number") choose(postureFromIndex(point.customdata));
    else if (Array.isArray(point.pointIndex)) {
      const [j, i] = point.pointIndex;
      choose(postureFromIndex(flatIndex([i, j, ...state.slice])));
    }
  });
}

function start() {
  const models = map.models.map((model) => [model, model]);
  if (models.length === 2) models.push([BOTH, "both, side by side"], [RATIO, "ratio refined / simplified"]);
  fill(control("quantity"), map.quantities.map((quantity) => [quantity.name, quantity.label]), state.quantity);
  fill(control("load"), map.loads.map((load) => [load, load]), state.load);
  fill(control("model"), models, state.model);
  fill(control("line-axis"), map.axes.map((axis, i) => [String(i), axis.name]), "0");
  control("lines-section").hidden = !map.isGrid || map.axes.length < 2;
  control("map").hidden = !HAS_MAP && HAS_VOLUME;
  watch("quantity", "quantity");
  watch("load", "load");
  watch("model", "model");
  watch("scale", "scale");
  watch("line-axis", "lineAxis", Number);
  watch("line-through", "through");
  makeSliders();
  draw();
  startBranches();
  ["map", "volume", "lines"].forEach(chooseOnClick);
  fitToPaperInPrint();
}

start();
