// What stands under the pointer, in words beside it.

function showReadout(chart, x, y) {
  const rows = chart.spec.kind === "heat" ? heatRows(chart, x, y) : chart.spec.equal ? planeRows(chart, x, y) : curveRows(chart, x);
  for (const peer of chart.peers) {
    peer.cursor = chart.spec.equal ? null : chart.vx(x);
    peer.draw();
  }
  const { tip, plot } = chart;
  tip.replaceChildren();
  if (!rows.length) return hideTip(chart);
  for (const [name, value, tint] of rows) {
    const row = tip.appendChild(document.createElement("div"));
    if (tint) row.appendChild(document.createElement("i")).style.background = tint;
    row.append(name ? `${name} ` : "");
    row.appendChild(document.createElement("b")).textContent = value;
  }
  tip.style.display = "block";
  const onRight = x < plot.left + plot.width / 2;
  tip.style.left = onRight ? `${x + 14}px` : "auto";
  tip.style.right = onRight ? "auto" : `${chart.size.width - x + 14}px`;
  tip.style.top = `${Math.max(0, Math.min(y - 10, chart.size.height - tip.offsetHeight))}px`;
}

function hideReadout(chart) {
  for (const peer of chart.peers) {
    peer.cursor = null;
    peer.draw();
  }
  hideTip(chart);
}

function hideTip(chart) {
  chart.tip.style.display = "none";
  chart.spot = null;
}

function curveRows(chart, x) {
  const at = chart.vx(x);
  if (at < chart.view.x0 || at > chart.view.x1) return [];
  const xStep = (chart.view.x1 - chart.view.x0) / 1000;
  const yStep = (chart.view.y1 - chart.view.y0) / 1000;
  const rows = [[chart.spec.xLabel, written(at, tenth(xStep))]];
  for (const series of chart.series) {
    if (series.hidden || !series.x.length) continue;
    const i = nearest(series.x, at);
    const isNear = Math.abs(chart.px(series.x[i]) - x) < 30;
    if (isNear && !Number.isNaN(series.y[i])) rows.push([series.name, written(series.y[i], tenth(yStep)), colour(series.colour)]);
  }
  return rows;
}

function planeRows(chart, x, y) {
  let best = 24 * 24;
  let found = null;
  for (const series of chart.series) {
    if (series.hidden) continue;
    for (let i = 0; i < series.x.length; i++) {
      const away = (chart.px(series.x[i]) - x) ** 2 + (chart.py(series.y[i]) - y) ** 2;
      if (away < best) {
        best = away;
        found = [series, i];
      }
    }
  }
  chart.spot = found && [found[0].x[found[1]], found[0].y[found[1]]];
  if (!found) return [];
  const step = tenth((chart.view.x1 - chart.view.x0) / 1000);
  return [
    [found[0].name, "", colour(found[0].colour)],
    [chart.spec.xLabel, written(chart.spot[0], step)],
    [chart.spec.yLabel, written(chart.spot[1], step)],
  ];
}

function heatRows(chart, x, y) {
  const { spec, plot } = chart;
  const row = Math.floor(((y - plot.top) / plot.height) * spec.rows.length);
  if (row < 0 || row >= spec.rows.length) return [];
  const at = chart.vx(x);
  const cells = spec.cells[row];
  const i = lowerBound(cells.start, at + 1e-12) - 1;
  const rows = [[spec.xLabel, written(at, tenth((chart.view.x1 - chart.view.x0) / 1000))]];
  if (i < 0 || at > cells.end[i] || Number.isNaN(cells.value[i])) return rows;
  const value = cells.value[i];
  const text = spec.states.length ? spec.states[Math.round(value)].name : `${value.toPrecision(4)} ${spec.unit}`;
  return [...rows, [spec.rows[row], text, heatColour(spec, value)]];
}

function tenth(step) {
  return 10 ** Math.floor(Math.log10(step));
}
