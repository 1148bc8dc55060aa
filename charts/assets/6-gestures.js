// Mouse, touch, wheel and keys. A page must still scroll: the wheel zooms only with Ctrl held or
// after a click on the chart, and one finger moves the page unless the chart is zoomed in.

function listen(chart) {
  const { box } = chart;
  const touches = new Map();
  let pinch = null;
  let press = null;

  const place = (event) => {
    const frame = box.getBoundingClientRect();
    return { x: event.clientX - frame.left, y: event.clientY - frame.top };
  };

  box.addEventListener("pointerdown", (event) => {
    if (event.button > 0) return;
    const at = place(event);
    touches.set(event.pointerId, at);
    box.setPointerCapture(event.pointerId);
    if (touches.size === 2) {
      press = chart.drag = null;
      pinch = spread(touches);
    } else if (touches.size === 1) {
      press = { from: at, last: at, pans: event.pointerType === "touch" || event.shiftKey, touch: event.pointerType === "touch" };
    }
  });

  box.addEventListener("pointermove", (event) => {
    const at = place(event);
    if (touches.has(event.pointerId)) touches.set(event.pointerId, at);
    if (pinch && touches.size === 2) {
      const now = spread(touches);
      chart.pan(now.x - pinch.x, now.y - pinch.y);
      chart.zoom(pinch.size / Math.max(1, now.size), now.x, now.y);
      pinch = now;
    } else if (press && press.pans && (chart.zoomed || !press.touch)) {
      chart.pan(at.x - press.last.x, at.y - press.last.y);
      press.last = at;
    } else if (press && !press.pans) {
      const { from } = press;
      chart.drag = Math.abs(at.x - from.x) > 4 || Math.abs(at.y - from.y) > 4 ? { x0: from.x, y0: from.y, x1: at.x, y1: at.y } : null;
      hideTip(chart);
      chart.draw();
    } else {
      showReadout(chart, at.x, at.y);
    }
  });

  const end = (event) => {
    touches.delete(event.pointerId);
    if (touches.size < 2) pinch = null;
    if (chart.drag && event.type === "pointerup") zoomToDrag(chart);
    else if (press && press.touch && event.type === "pointerup" && press.last === press.from) showReadout(chart, press.from.x, press.from.y);
    press = chart.drag = null;
    chart.draw();
  };
  box.addEventListener("pointerup", end);
  box.addEventListener("pointercancel", end);
  box.addEventListener("pointerleave", (event) => {
    if (event.pointerType !== "touch") hideReadout(chart);
  });
  box.addEventListener("dblclick", () => chart.reset());
  box.addEventListener(
    "wheel",
    (event) => {
      if (!event.ctrlKey && !event.metaKey && document.activeElement !== box) return;
      event.preventDefault();
      const at = place(event);
      chart.zoom(Math.exp(Math.max(-1, Math.min(1, event.deltaY * 0.002))), at.x, at.y);
    },
    { passive: false },
  );
  box.addEventListener("keydown", (event) => {
    const step = chart.plot.width / 8;
    const acts = {
      ArrowLeft: () => chart.pan(step, 0),
      ArrowRight: () => chart.pan(-step, 0),
      ArrowUp: () => chart.spec.equal && chart.pan(0, step),
      ArrowDown: () => chart.spec.equal && chart.pan(0, -step),
      "+": () => chart.zoom(1 / 1.6),
      "-": () => chart.zoom(1.6),
      0: () => chart.reset(),
      Escape: () => chart.reset(),
    };
    if (!acts[event.key] || event.target !== box) return;
    event.preventDefault();
    acts[event.key]();
  });
}

function spread(touches) {
  const [one, other] = [...touches.values()];
  return { x: (one.x + other.x) / 2, y: (one.y + other.y) / 2, size: Math.hypot(one.x - other.x, one.y - other.y) };
}

function zoomToDrag(chart) {
  const { x0, x1, y0, y1 } = chart.drag;
  if (Math.abs(x1 - x0) < 5 && !chart.spec.equal) return;
  chart.look({
    x0: chart.vx(Math.min(x0, x1)),
    x1: chart.vx(Math.max(x0, x1)),
    y0: chart.vy(Math.max(y0, y1)),
    y1: chart.vy(Math.min(y0, y1)),
  });
}
