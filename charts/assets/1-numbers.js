// Numbers: unpacking, searching, ticks and how a value is written.

function unpack(packed) {
  const bytes = Uint8Array.from(atob(packed.f32), (letter) => letter.charCodeAt(0));
  return Float64Array.from(new Float32Array(bytes.buffer), (value) => value + packed.offset);
}

// First index whose value is not below `limit` in an increasing array.
function lowerBound(values, limit) {
  let low = 0;
  let high = values.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (values[middle] < limit) low = middle + 1;
    else high = middle;
  }
  return low;
}

function nearest(values, wanted) {
  const right = Math.min(values.length - 1, lowerBound(values, wanted));
  const left = Math.max(0, right - 1);
  return wanted - values[left] <= values[right] - wanted ? left : right;
}

function extent(arrays, within) {
  let low = Infinity;
  let high = -Infinity;
  for (const [values, start, end] of arrays) {
    for (let i = start; i < end; i++) {
      const value = values[i];
      if (value < low) low = value;
      if (value > high) high = value;
    }
  }
  if (low > high) return within || [0, 1];
  return [low, high];
}

function padded([low, high], part) {
  const room = high > low ? (high - low) * part : Math.max(Math.abs(low) * 1e-3, 1e-9);
  return [low - room, high + room];
}

// A step of 1, 2 or 5 times a power of ten that gives about `wanted` ticks.
function tickStep(low, high, wanted) {
  const rough = (high - low) / Math.max(1, wanted);
  const power = 10 ** Math.floor(Math.log10(rough));
  const factor = rough / power;
  return power * (factor <= 1 ? 1 : factor <= 2 ? 2 : factor <= 5 ? 5 : 10);
}

function ticks(low, high, wanted) {
  const step = tickStep(low, high, wanted);
  if (!(step > 0) || !isFinite(step)) return { step: 1, values: [] };
  const first = Math.ceil(low / step - 1e-9);
  const last = Math.floor(high / step + 1e-9);
  const values = [];
  for (let i = first; i <= last && values.length < 50; i++) values.push(i * step);
  return { step, values };
}

// At least two ticks where there is a range: a single one tells no scale.
function scaleTicks(low, high, wanted) {
  let found = ticks(low, high, wanted);
  for (let more = Math.max(1, wanted); found.values.length < 2 && more < 20; more *= 1.5) found = ticks(low, high, more);
  return found;
}

// As many digits as the step needs to tell one tick from the next.
function written(value, step) {
  if (value === 0) return "0";
  const size = Math.max(Math.abs(value), step);
  if (size >= 1e6 || size < 1e-4) return value.toExponential(Math.max(0, Math.ceil(Math.log10(size / step) - 0.01)));
  const decimals = Math.max(0, Math.min(9, -Math.floor(Math.log10(step) + 1e-9)));
  const text = value.toFixed(decimals);
  return Number(text) === 0 ? "0" : text.replace("-", "\u2212");
}
