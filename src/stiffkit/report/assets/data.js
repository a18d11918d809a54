// The numbers of the map, as Python left them, and how to read them.

const map = JSON.parse(await unpacked("data"));
const RATIO = "ratio";
const BOTH = "both";
const STATUS = ["computed", "out of reach", "singular", "uncontrolled", "outside the workspace"];

function quantityNamed(name) {
  return map.quantities.find((quantity) => quantity.name === name);
}

function keyOf(quantity, model, load) {
  return JSON.stringify([quantity.name, model, quantity.perLoad ? load : ""]);
}

function unitOf(quantity, model, load) {
  return model === RATIO ? "" : quantity.units[quantity.perLoad ? load : ""];
}

function valuesOf(quantity, model, load) {
  if (model !== RATIO) return decode(map.values[keyOf(quantity, model, load)]);
  const refined = valuesOf(quantity, "refined", load);
  const simplified = valuesOf(quantity, "simplified", load);
  return refined.map((value, i) => {
    const ratio = value / simplified[i];
    return Number.isFinite(simplified[i]) && Number.isFinite(ratio) ? ratio : NaN;
  });
}

// "both" is two panels, anything else one.
function modelsShown(model) {
  return model === BOTH ? map.models : [model];
}

function statusOf(model, index) {
  return Number(map.status[model === RATIO ? map.models[0] : model][index]);
}

// Flat index of a posture of a grid (C order), and back.
function flatIndex(where) {
  return where.reduce((flat, i, axis) => flat * map.shape[axis] + i, 0);
}

function gridIndex(flat) {
  const where = new Array(map.shape.length);
  for (let axis = map.shape.length - 1; axis >= 0; axis -= 1) {
    where[axis] = flat % map.shape[axis];
    flat = Math.floor(flat / map.shape[axis]);
  }
  return where;
}

function coordinatesOf(index) {
  const where = map.isGrid ? gridIndex(index) : map.axes.map(() => index);
  return map.axes.map((axis, i) => axis.values[where[i]]);
}

function nearest(values, wanted) {
  let best = 0;
  values.forEach((value, i) => {
    if (Math.abs(value - wanted) < Math.abs(values[best] - wanted)) best = i;
  });
  return best;
}

function modelName(model) {
  return model === RATIO ? "refined / simplified" : `${model} model`;
}

function hoverText(quantity, load, index) {
  const at = coordinatesOf(index);
  const lines = [map.axes.map((axis, i) => `${axis.name} = ${withUnit(format(at[i]), axis.unit)}`).join(", ")];
  const status = statusOf(map.models[0], index);
  if (status !== 0) return `${lines[0]}<br><b>${STATUS[status]}</b>`;
  for (const model of map.models) {
    const value = format(valuesOf(quantity, model, load)[index]);
    lines.push(`${model}: <b>${withUnit(value, unitOf(quantity, model, load))}</b>`);
  }
  const others = map.others.slice(0, 12).map((other) => {
    return `${plain(other.name)} = ${withUnit(format(decode(other.data)[index]), other.unit)}`;
  });
  if (map.others.length > others.length) others.push("…");
  return lines.concat(others).join("<br>");
}
