// The table of the worst postures, and all about the chosen one.

function element(tag, text, attributes = {}) {
  const made = document.createElement(tag);
  if (text !== undefined) made.textContent = text;
  Object.entries(attributes).forEach(([name, value]) => made.setAttribute(name, value));
  return made;
}

function drawWorst(state, choose) {
  const quantity = quantityNamed(state.quantity);
  const model = state.model === BOTH ? map.models[0] : state.model;
  const rows = map.worst[keyOf(quantity, model, state.load)];
  const unit = unitOf(quantity, model, state.load);
  const worst = quantity.worstIsLargest ? "Largest" : "Lowest";
  const load = quantity.perLoad ? `, load ${state.load}` : "";
  document.getElementById("worst-heading").textContent = `${worst} values: ${modelName(model)}${load}`;
  const table = document.getElementById("worst");
  table.replaceChildren();
  const telling = rows.length > 0 && !rows.every((row) => row.value === "0");
  document.getElementById("worst-hint").textContent = telling
    ? "Choose a row to mark it on the map."
    : "This model has no deflection to rank here.";
  if (!telling) return;
  table.append(worstHead(unit));
  const body = element("tbody");
  rows.forEach((row, i) => body.append(worstRow(row, i, state, choose)));
  table.append(body);
}

function worstHead(unit) {
  const head = element("tr");
  head.append(element("th", "", { scope: "col" }));
  map.axes.forEach((axis) => head.append(element("th", label(axis.name, axis.unit), { scope: "col" })));
  head.append(element("th", label("value", unit), { scope: "col" }));
  const section = element("thead");
  section.append(head);
  return section;
}

function worstRow(row, i, state, choose) {
  const line = element("tr");
  const mark = element("td");
  mark.append(element("button", String(i + 1), { type: "button", "aria-label": `Mark posture ${i + 1} on the map` }));
  line.append(mark, ...row.at.map((value) => element("td", format(value))), element("td", row.value));
  line.classList.toggle("chosen", Boolean(state.chosen) && state.chosen.id === JSON.stringify(row.at));
  line.addEventListener("click", () => choose(postureFromRow(row)));
  return line;
}

function postureFromRow(row) {
  return { id: JSON.stringify(row.at), at: row.at, status: 0, coordinates: row.pose, joints: row.joints };
}

// A posture that was clicked on a plot.
function postureFromIndex(index) {
  const at = coordinatesOf(index);
  const coordinates = map.axes.map((axis, i) => [axis.name, format(at[i]), axis.unit]);
  const joints = map.others.map((other) => [other.name, format(decode(other.data)[index]), other.unit]);
  return { id: JSON.stringify(at), at, status: statusOf(map.models[0], index), coordinates, joints };
}

function drawPosture(state) {
  const place = document.getElementById("posture");
  place.replaceChildren();
  if (!state.chosen) return;
  const table = element("table", undefined, { class: "pairs" });
  const body = element("tbody");
  const row = (name, text) => {
    const line = element("tr");
    line.append(element("th", name, { scope: "row" }), element("td", text));
    body.append(line);
  };
  if (state.chosen.status) row("status", STATUS[state.chosen.status]);
  [...state.chosen.coordinates, ...state.chosen.joints].forEach(([name, text, unit]) => row(name, withUnit(text, unit)));
  table.append(body);
  place.append(element("h3", "Chosen posture"), table);
}
