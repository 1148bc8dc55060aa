// Painting: everything that puts something on a canvas. `plot` is {left, top, width, height}.

const FONT = "12px system-ui, sans-serif";

function paintGrid(pen, chart) {
  const { plot, view, spec } = chart;
  pen.font = FONT;
  pen.lineWidth = 1;
  const across = ticks(view.x0, view.x1, plot.width / 80);
  pen.textAlign = "center";
  pen.textBaseline = "top";
  for (const value of across.values) {
    const x = Math.round(chart.px(value)) + 0.5;
    pen.strokeStyle = colour("grid");
    line(pen, x, plot.top, x, plot.top + plot.height);
    pen.fillStyle = colour("soft");
    const text = written(value, across.step);
    const half = pen.measureText(text).width / 2;
    pen.fillText(text, Math.min(Math.max(x, half), chart.size.width - half), plot.top + plot.height + 5);
  }
  pen.fillStyle = colour("soft");
  pen.fillText(spec.xLabel, plot.left + plot.width / 2, plot.top + plot.height + 21);
  if (spec.kind === "heat") return paintRowNames(pen, chart);
  const up = chart.yTicks();
  pen.textAlign = "right";
  pen.textBaseline = "middle";
  for (const value of up.values) {
    const y = Math.round(chart.py(value)) + 0.5;
    pen.strokeStyle = colour(value === 0 ? "axis" : "grid");
    line(pen, plot.left, y, plot.left + plot.width, y);
    pen.fillStyle = colour("soft");
    pen.fillText(written(value, up.step), plot.left - 6, y);
  }
  pen.textAlign = "left";
  pen.textBaseline = "top";
  pen.fillText(spec.yLabel, 2, 4);
}

function paintRowNames(pen, { plot, spec }) {
  const height = plot.height / spec.rows.length;
  pen.textAlign = "right";
  pen.textBaseline = "middle";
  spec.rows.forEach((name, row) => pen.fillText(name, plot.left - 6, plot.top + height * (row + 0.5)));
}

function line(pen, x0, y0, x1, y1) {
  pen.beginPath();
  pen.moveTo(x0, y0);
  pen.lineTo(x1, y1);
  pen.stroke();
}

function paintSpans(pen, chart) {
  const { plot, spec } = chart;
  pen.textAlign = "left";
  pen.textBaseline = "bottom";
  for (const span of spec.spans || []) {
    const x0 = Math.max(plot.left, chart.px(span.start));
    const x1 = Math.min(plot.left + plot.width, chart.px(span.end));
    if (x1 <= x0) continue;
    pen.globalAlpha = 0.12;
    pen.fillStyle = colour(span.colour);
    pen.fillRect(x0, plot.top, Math.max(1, x1 - x0), plot.height);
    pen.globalAlpha = 1;
    pen.fillStyle = colour("soft");
    if (pen.measureText(span.label).width < x1 - x0 - 8) {
      pen.fillText(span.label, x0 + 4, plot.top + plot.height - 3);
    }
  }
}

// Labels of marks stand on two lines in turn; one that finds no room is left to the table.
function paintMarks(pen, chart) {
  const { plot, spec } = chart;
  const free = [-Infinity, -Infinity];
  pen.textAlign = "left";
  pen.textBaseline = "top";
  for (const mark of spec.marks || []) {
    const x = Math.round(chart.px(mark.x)) + 0.5;
    if (x < plot.left || x > plot.left + plot.width) continue;
    pen.strokeStyle = colour(mark.colour);
    pen.setLineDash([3, 3]);
    line(pen, x, plot.top, x, plot.top + plot.height);
    pen.setLineDash([]);
    const width = pen.measureText(mark.label).width;
    const row = free[0] <= x ? 0 : free[1] <= x ? 1 : -1;
    if (row < 0 || x + width + 4 > plot.left + plot.width) continue;
    free[row] = x + width + 10;
    pen.fillStyle = colour(mark.colour);
    pen.fillText(mark.label, x + 4, plot.top + 2 + 14 * row);
  }
}

function paintSeries(pen, chart, series) {
  const [start, end] = chart.shown(series);
  pen.strokeStyle = pen.fillStyle = colour(series.colour);
  pen.lineWidth = 1.6;
  pen.lineJoin = "round";
  pen.setLineDash(series.dashed ? [6, 4] : []);
  if (series.low && series.high) paintBand(pen, chart, series, start, end);
  if (series.style === "points") paintPoints(pen, chart, series, start, end);
  else if (series.style === "bars") paintBars(pen, chart, series, start, end);
  else if (series.sorted && end - start > 4 * chart.plot.width) paintDense(pen, chart, series, start, end);
  else paintLine(pen, chart, series, start, end);
  pen.setLineDash([]);
}

function paintLine(pen, chart, series, start, end) {
  let inside = false;
  pen.beginPath();
  for (let i = start; i < end; i++) {
    const x = chart.px(series.x[i]);
    const y = chart.py(series.y[i]);
    if (Number.isNaN(x + y)) {
      inside = false;
      continue;
    }
    if (!inside) pen.moveTo(x, y);
    else {
      if (series.style === "step") pen.lineTo(x, chart.py(series.y[i - 1]));
      pen.lineTo(x, y);
    }
    inside = true;
  }
  pen.stroke();
}

// More points than pixels: one upright stroke a column, from its lowest to its highest value.
function paintDense(pen, chart, series, start, end) {
  const { plot } = chart;
  let column = -1;
  let low = NaN;
  let high = NaN;
  let last = NaN;
  pen.beginPath();
  const flush = () => {
    if (Number.isNaN(low)) return;
    const x = plot.left + column + 0.5;
    if (Number.isNaN(last)) pen.moveTo(x, low);
    else pen.lineTo(x, low);
    pen.lineTo(x, high);
    last = high;
  };
  for (let i = start; i < end; i++) {
    const here = Math.floor(chart.px(series.x[i]) - plot.left);
    const y = chart.py(series.y[i]);
    if (here !== column) {
      flush();
      column = here;
      low = high = NaN;
    }
    if (Number.isNaN(y)) {
      flush();
      low = high = last = NaN;
      continue;
    }
    if (!(y >= low)) low = y;
    if (!(y <= high)) high = y;
  }
  flush();
  pen.stroke();
}

function paintPoints(pen, chart, series, start, end) {
  const size = end - start > 2 * chart.plot.width ? 2 : 3.2;
  pen.globalAlpha = end - start > chart.plot.width ? 0.6 : 0.85;
  for (let i = start; i < end; i++) {
    const x = chart.px(series.x[i]);
    const y = chart.py(series.y[i]);
    if (!Number.isNaN(x + y)) pen.fillRect(x - size / 2, y - size / 2, size, size);
  }
  pen.globalAlpha = 1;
}

function paintBars(pen, chart, series, start, end) {
  const step = series.x.length > 1 ? series.x[1] - series.x[0] : 1;
  const width = Math.max(1, chart.px(series.x[0] + step) - chart.px(series.x[0]) - 1);
  const zero = chart.py(0);
  for (let i = start; i < end; i++) {
    const y = chart.py(series.y[i]);
    if (!Number.isNaN(y)) pen.fillRect(chart.px(series.x[i]) - width / 2, Math.min(y, zero), width, Math.abs(zero - y));
  }
}

function paintBand(pen, chart, series, start, end) {
  pen.globalAlpha = 0.18;
  pen.beginPath();
  for (let i = start; i < end; i++) {
    if (!Number.isNaN(series.high[i])) pen.lineTo(chart.px(series.x[i]), chart.py(series.high[i]));
  }
  for (let i = end - 1; i >= start; i--) {
    if (!Number.isNaN(series.low[i])) pen.lineTo(chart.px(series.x[i]), chart.py(series.low[i]));
  }
  pen.fill();
  pen.globalAlpha = 1;
}

// States are listed from best to worst, and the worst is painted last: a single bad sample among
// thousands must not vanish under its neighbours.
function paintHeat(pen, chart) {
  const { states } = chart.spec;
  const passes = states.length ? states.map((_, state) => (value) => Math.round(value) === state) : [(value) => !Number.isNaN(value)];
  for (const wanted of passes) chart.spec.cells.forEach((cells, row) => paintCells(pen, chart, cells, row, wanted));
}

function paintCells(pen, chart, cells, row, wanted) {
  const { plot, spec, view } = chart;
  const height = plot.height / spec.rows.length;
  const first = Math.max(0, lowerBound(cells.start, view.x0) - 1);
  for (let i = first; i < cells.start.length && cells.start[i] < view.x1; i++) {
    if (!wanted(cells.value[i])) continue;
    const x0 = Math.max(plot.left, chart.px(cells.start[i]));
    const x1 = Math.min(plot.left + plot.width, chart.px(cells.end[i]));
    pen.fillStyle = heatColour(spec, cells.value[i]);
    pen.fillRect(x0, plot.top + row * height + 1, Math.max(1, x1 - x0 + 0.3), height - 2);
  }
}

function heatColour(spec, value) {
  if (spec.states.length) return colour(spec.states[Math.round(value)].colour);
  return ramp((value - spec.low) / (spec.high - spec.low || 1));
}
