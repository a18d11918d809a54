// How every plot on the page looks, and its colour scale.

const FONT = {
  family: 'system-ui, -apple-system, "Segoe UI", Roboto, "Helvetica Neue", Arial, sans-serif',
  size: 12.5,
  color: "#1c2127",
};
const GAP_COLOURS = { 1: "#dcdfe3", 2: "#5a5a5a", 3: "#9a9a9a", 4: "#ffffff" };
// What tells gaps from colours, and from each other, where all are grey.
const GAP_MARKS = {
  1: { symbol: "line-ne", size: 8, line: { width: 1.2, color: "#98a1aa" } },
  2: { symbol: "x-thin", size: 6, line: { width: 1.4, color: "#ffffff" } },
  3: { symbol: "circle", size: 3.5, color: "#ffffff", line: { width: 0 } },
};
const MARKS_ALONG = 32;
const LINE_LOOK = {
  refined: { color: "#0072b2", dash: "solid" },
  simplified: { color: "#d55e00", dash: "dash" },
  ratio: { color: "#0072b2", dash: "solid" },
};
const MARK = { symbol: "circle-open", size: 15, color: "#d55e00", line: { width: 3, color: "#d55e00" } };
// The buttons are listed one by one: none of them talks to another site.
const BUTTONS = {
  map: [["zoom2d", "pan2d", "resetScale2d", "toImage"]],
  volume: [["orbitRotation", "pan3d", "resetCameraDefault3d", "toImage"]],
  lines: [["toImage"]],
  branches: [["toImage"]],
};
// From this spread on, a linear scale would hide the small values.
const LOGARITHMIC_FROM = 6;

function baseLayout(height) {
  return {
    height,
    font: FONT,
    margin: { l: 64, r: 16, t: TOP, b: 50 },
    paper_bgcolor: "rgba(0,0,0,0)",
    plot_bgcolor: "#ffffff",
    hoverlabel: { align: "left", bgcolor: "#ffffff", bordercolor: "#9aa3ac", font: { ...FONT, size: 12 } },
    hovermode: "closest",
    showlegend: false,
    modebar: { bgcolor: "rgba(255,255,255,0.6)", color: "#a8b0b8", activecolor: "#0072b2" },
  };
}

function axisLayout(axis, more) {
  return {
    title: { text: label(axis.name, axis.unit), standoff: 8 },
    showgrid: false,
    zeroline: false,
    ticks: "outside",
    ticklen: 4,
    showline: true,
    mirror: true,
    linecolor: "#7d868f",
    ...more,
  };
}

// Limits over all columns of values; what has no logarithm or no size does not count, and a few
// postures next to a singularity do not stretch the scale over decades.
const OUTLIERS = 0.05;
const FAR = 3;

function scaleOf(columns, choice) {
  let low = Infinity;
  const positive = [];
  for (const column of columns) {
    for (const value of column) {
      if (!Number.isFinite(value)) continue;
      low = Math.min(low, value);
      if (value > 0) positive.push(value);
    }
  }
  if (low === Infinity) return { low: 0, high: 1, log: false, empty: true };
  if (positive.length === 0) return { low, high: 0, log: false, empty: false };
  const sorted = Float64Array.from(positive).sort();
  const at = (share) => sorted[Math.round(share * (sorted.length - 1))];
  const least = Math.max(sorted[0], at(OUTLIERS) / FAR);
  const high = Math.min(sorted[sorted.length - 1], at(1 - OUTLIERS) * FAR);
  const canLog = least < high;
  const log = canLog && (choice === "log" || (choice === "auto" && high > LOGARITHMIC_FROM * least));
  return { low: log ? least : low, high, log, empty: false };
}

function toScale(value, scale) {
  if (Number.isNaN(value)) return null;
  const inside = Math.min(Math.max(value, scale.low), scale.high);
  return scale.log ? Math.log10(inside) : inside;
}

// Labels within a decade, from few to many, and how few labels would pass for a linear axis.
const LOG_STEPS = [
  [1, 2, 5],
  [1, 1.5, 2, 3, 4, 5, 6, 8],
  [1, 1.2, 1.4, 1.6, 1.8, 2, 2.5, 3, 4, 5, 6, 7, 8, 9],
];
const FEW_TICKS = 3;

function logTicks(scale) {
  if (Math.log10(scale.high / scale.low) > 4) return ticksAt([1], scale);
  const choices = LOG_STEPS.map((steps) => ticksAt(steps, scale));
  return choices.find((ticks) => ticks.length > FEW_TICKS) ?? evenTicks(scale);
}

// Over so little of a decade a logarithmic axis is as good as linear.
function evenTicks({ low, high }) {
  const least = (high - low) / 10;
  const power = 10 ** Math.floor(Math.log10(least));
  const step = power * [1, 2, 5, 10].find((size) => size * power >= least);
  const first = Math.ceil(low / step);
  return Array.from({ length: Math.floor(high / step) - first + 1 }, (_, i) => (first + i) * step);
}

function ticksAt(steps, scale) {
  const ticks = [];
  for (let power = Math.floor(Math.log10(scale.low)); 10 ** power <= scale.high; power += 1) {
    for (const step of steps) {
      const tick = step * 10 ** power;
      if (tick >= scale.low * 0.999 && tick <= scale.high * 1.001) ticks.push(tick);
    }
  }
  return ticks;
}

function colourAxis(scale, title, isRatio) {
  const [low, high] = [scale.low, scale.high].map((value) => (scale.log ? Math.log10(value) : value));
  const ticks = scale.log ? logTicks(scale) : null;
  return {
    colorscale: isRatio ? "Cividis" : "Viridis",
    cmin: low,
    cmax: high > low ? high : low + (Math.abs(low) || 1),
    colorbar: {
      title: { text: title, side: "right" },
      thickness: 16,
      outlinewidth: 0,
      ...(ticks ? { tickvals: ticks.map(Math.log10), ticktext: ticks.map(format) } : {}),
    },
  };
}

// What to write over a panel that has no colours to tell of, or null.
function emptiness(values) {
  const known = values.filter((value) => !Number.isNaN(value));
  if (known.length === 0) return "no value";
  if (known.every((value) => value === 0)) return "zero in this model";
  if (known.every((value) => !Number.isFinite(value))) return "rigid in this model";
  return null;
}

// Legends stand over the notes on paper, where there is no room for them side by side.
const LEGEND = { orientation: "h", x: 0.95, xanchor: "right", y: 1.01, yanchor: "bottom" };
const LEGEND_ON_PAPER = { orientation: "h", x: 0, xanchor: "left", y: 1.09, yanchor: "bottom" };
const TOP = 34;

const WIDTH_ON_PAPER = 660;

function fitToPaperInPrint() {
  const plots = () => [...document.querySelectorAll(".js-plotly-plot")];
  // A plot in space would be drawn anew too late for the printer; its picture is made smaller.
  const spaces = () => plots().filter((shown) => shown.layout.scene);
  const fit = (size, legend, t) => plots().filter((shown) => !shown.layout.scene).forEach((shown) => {
    Plotly.relayout(shown, shown.layout.showlegend ? { ...size, legend, "margin.t": t } : size);
  });
  window.addEventListener("beforeprint", () => {
    fit({ width: WIDTH_ON_PAPER }, LEGEND_ON_PAPER, TOP + 24);
    spaces().forEach((shown) => { shown.style.zoom = Math.min(1, WIDTH_ON_PAPER / shown.clientWidth); });
  });
  window.addEventListener("afterprint", () => {
    fit({ width: null, autosize: true }, LEGEND, TOP);
    spaces().forEach((shown) => { shown.style.zoom = ""; });
  });
}
