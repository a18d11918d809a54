// Numbers that Python left in a page, and how they are written.

const decoded = new Map();

function decode(text) {
  if (!decoded.has(text)) {
    const bytes = Uint8Array.from(atob(text), (character) => character.charCodeAt(0));
    const view = new DataView(bytes.buffer);
    const numbers = new Float64Array(bytes.length / 4);
    for (let i = 0; i < numbers.length; i += 1) numbers[i] = view.getFloat32(4 * i, true);
    decoded.set(text, numbers);
  }
  return decoded.get(text);
}

function format(value) {
  if (Number.isNaN(value)) return "–";
  if (!Number.isFinite(value)) return "∞";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size < 1e-3 || size >= 1e6) return value.toExponential(3).replace(/-/g, "−");
  const digits = Math.max(0, 3 - Math.floor(Math.log10(size)));
  return String(Number(value.toFixed(digits))).replace("-", "−");
}

function withUnit(text, unit) {
  if (!unit) return text;
  return unit === "°" ? `${text}°` : `${text} ${unit}`;
}

function label(text, unit) {
  return unit ? `${text} (${unit})` : text;
}

// Plotly reads a little HTML in its texts; names from the robot file are plain text.
function plain(text) {
  return String(text).replace(/&/g, "&amp;").replace(/</g, "&lt;").replace(/>/g, "&gt;");
}
