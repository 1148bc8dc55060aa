// One chart: its data, what part of it is seen, and the pieces of page around the canvas.

class Chart {
  constructor(figure) {
    this.figure = figure;
    this.spec = JSON.parse(figure.querySelector("script").textContent);
    this.box = figure.querySelector(".plot");
    this.peers = [this];
    this.cursor = null;
    this.frame = 0;
    this.read();
    this.furnish();
    this.home = this.wholeX();
    new ResizeObserver(() => this.resize()).observe(this.box);
  }

  read() {
    const { spec } = this;
    this.series = spec.series || [];
    for (const series of this.series) {
      for (const name of ["x", "y", "low", "high"]) if (series[name]) series[name] = unpack(series[name]);
    }
    for (const cells of spec.cells || []) {
      for (const name of ["start", "end", "value"]) cells[name] = unpack(cells[name]);
    }
  }

  furnish() {
    this.canvas = this.box.appendChild(document.createElement("canvas"));
    this.tip = this.box.appendChild(document.createElement("div"));
    this.tip.className = "tip";
    const tools = this.figure.querySelector("figcaption").appendChild(document.createElement("span"));
    tools.className = "tools";
    const tool = (text, says, act) => {
      const button = tools.appendChild(document.createElement("button"));
      button.type = "button";
      button.textContent = text;
      button.title = says;
      button.setAttribute("aria-label", says);
      button.addEventListener("click", act);
    };
    tool("\u2212", "zoom out", () => this.zoom(1.6));
    tool("+", "zoom in", () => this.zoom(1 / 1.6));
    tool("\u21ba", "show everything", () => this.reset());
    this.legend();
  }

  legend() {
    const { spec } = this;
    const entries = spec.kind === "heat" ? spec.states : this.series;
    const isRamp = spec.kind === "heat" && !spec.states.length;
    if (!isRamp && entries.length < 2) return;
    const list = document.createElement("div");
    list.className = "legend";
    this.box.before(list);
    if (isRamp) return this.rampLegend(list);
    for (const entry of entries) {
      const button = list.appendChild(document.createElement(spec.kind === "heat" ? "span" : "button"));
      const swatch = button.appendChild(document.createElement("i"));
      swatch.style.background = `var(--${entry.colour})`;
      swatch.className = entry.dashed ? "dashed" : entry.style || "cell";
      button.append(entry.name);
      if (spec.kind === "heat") continue;
      button.type = "button";
      button.setAttribute("aria-pressed", String(!entry.hidden));
      button.addEventListener("click", () => {
        entry.hidden = !entry.hidden;
        button.setAttribute("aria-pressed", String(!entry.hidden));
        this.draw();
      });
    }
  }

  rampLegend(list) {
    const { low, high, unit } = this.spec;
    const step = tickStep(low, high, 100);
    list.append(`${written(low, step)} `);
    for (let k = 0; k < 12; k++) {
      const swatch = list.appendChild(document.createElement("i"));
      swatch.className = "cell";
      swatch.dataset.ramp = String(k / 11);
    }
    list.append(` ${written(high, step)} ${unit}`);
  }

  wholeX() {
    if (this.spec.kind === "heat") {
      return extent(this.spec.cells.flatMap((c) => [[c.start, 0, c.start.length], [c.end, 0, c.end.length]]));
    }
    const found = extent(this.series.map((series) => [series.x, 0, series.x.length]));
    const bars = this.series.find((series) => series.style === "bars" && series.x.length > 1);
    const room = bars ? (bars.x[1] - bars.x[0]) / 2 : 0;
    return found[1] > found[0] ? [found[0] - room, found[1] + room] : padded(found, 0);
  }

  // Shows everything; with a group, everything any chart of the group has.
  reset() {
    for (const peer of this.peers) {
      const [x0, x1] = extent(this.peers.map((one) => [one.home, 0, 2]));
      peer.zoomed = false;
      if (peer.spec.equal && peer.plot) peer.fit(peer.wholePlane());
      else peer.view = { x0, x1 };
      peer.draw();
    }
  }

  wholePlane() {
    const shown = this.series.filter((series) => !series.hidden);
    const [x0, x1] = padded(extent(shown.map((s) => [s.x, 0, s.x.length])), 0.05);
    const [y0, y1] = padded(extent(shown.map((s) => [s.y, 0, s.y.length])), 0.05);
    return { x0, x1, y0, y1 };
  }

  // Same length on paper along x and y: the tighter direction decides.
  fit({ x0, x1, y0, y1 }) {
    const scale = Math.max((x1 - x0) / this.plot.width, (y1 - y0) / this.plot.height);
    const halfX = (scale * this.plot.width) / 2;
    const halfY = (scale * this.plot.height) / 2;
    const middleX = (x0 + x1) / 2;
    const middleY = (y0 + y1) / 2;
    this.view = { x0: middleX - halfX, x1: middleX + halfX, y0: middleY - halfY, y1: middleY + halfY };
  }

  look(view) {
    const size = view.x1 - view.x0;
    if (!(size > Math.abs(view.x0) * 1e-9) || !(size < 1e15)) return;
    for (const peer of this.peers) {
      peer.zoomed = true;
      if (peer.spec.equal) peer.fit(view);
      else peer.view = { x0: view.x0, x1: view.x1 };
      peer.draw();
    }
  }

  zoom(factor, x = this.plot.left + this.plot.width / 2, y = this.plot.top + this.plot.height / 2) {
    const { view } = this;
    const atX = this.vx(x);
    const wanted = { x0: atX + (view.x0 - atX) * factor, x1: atX + (view.x1 - atX) * factor };
    if (this.spec.equal) {
      const atY = this.vy(y);
      wanted.y0 = atY + (view.y0 - atY) * factor;
      wanted.y1 = atY + (view.y1 - atY) * factor;
    }
    this.look(wanted);
  }

  pan(pixelsX, pixelsY) {
    const { view, plot } = this;
    const dx = (pixelsX * (view.x1 - view.x0)) / plot.width;
    const dy = (pixelsY * (view.y1 - view.y0)) / plot.height;
    this.look({ x0: view.x0 - dx, x1: view.x1 - dx, y0: view.y0 + dy, y1: view.y1 + dy });
  }

  px(value) {
    return this.plot.left + ((value - this.view.x0) / (this.view.x1 - this.view.x0)) * this.plot.width;
  }

  py(value) {
    return this.plot.top + ((this.view.y1 - value) / (this.view.y1 - this.view.y0)) * this.plot.height;
  }

  vx(pixel) {
    return this.view.x0 + ((pixel - this.plot.left) / this.plot.width) * (this.view.x1 - this.view.x0);
  }

  vy(pixel) {
    return this.view.y1 - ((pixel - this.plot.top) / this.plot.height) * (this.view.y1 - this.view.y0);
  }

  yTicks() {
    return scaleTicks(this.view.y0, this.view.y1, this.plot.height / (this.spec.equal ? 80 : 45));
  }

  // Indices of a series that touch the view.
  shown(series) {
    if (!series.sorted) return [0, series.x.length];
    const start = Math.max(0, lowerBound(series.x, this.view.x0) - 1);
    return [start, Math.min(series.x.length, lowerBound(series.x, this.view.x1) + 1)];
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.box;
    if (!width) return;
    const sharp = window.devicePixelRatio || 1;
    this.canvas.width = Math.round(width * sharp);
    this.canvas.height = Math.round(height * sharp);
    this.pen = this.canvas.getContext("2d");
    this.pen.setTransform(sharp, 0, 0, sharp, 0, 0);
    this.size = { width, height };
    this.layout(this.plot ? this.plot.left : 48);
    if (!this.view) return this.reset();
    if (this.spec.equal) this.fit(this.zoomed ? this.view : this.wholePlane());
    this.draw();
  }

  layout(left) {
    const top = this.spec.kind === "heat" ? 4 : 24;
    const { width, height } = this.size;
    this.plot = { left, top, width: Math.max(20, width - left - 8), height: Math.max(20, height - top - 40) };
  }

  draw() {
    if (this.pen && !this.frame) {
      this.frame = requestAnimationFrame(() => {
        this.frame = 0;
        this.paint();
      });
    }
  }

  // Heights follow what is seen; the left margin follows the widest number.
  settle() {
    const { pen, spec } = this;
    pen.font = FONT;
    if (spec.kind === "heat") {
      this.margin(Math.max(...spec.rows.map((name) => pen.measureText(name).width)) + 12);
      return;
    }
    if (!spec.equal) {
      const shown = this.series.filter((series) => !series.hidden);
      const parts = shown.flatMap((series) => {
        const [start, end] = this.shown(series);
        const zero = series.style === "bars" ? [[[0], 0, 1]] : [];
        return ["y", "low", "high"].filter((name) => series[name]).map((name) => [series[name], start, end]).concat(zero);
      });
      [this.view.y0, this.view.y1] = padded(extent(parts), 0.06);
    }
    const { values, step } = this.yTicks();
    const widest = Math.max(0, ...values.map((value) => pen.measureText(written(value, step)).width));
    this.margin(Math.ceil(widest / 8) * 8 + 12);
  }

  // Charts of a group start at the same place, so that times stand above one another.
  margin(wanted) {
    this.wanted = wanted;
    const left = Math.max(...this.peers.map((peer) => peer.wanted || 0));
    for (const peer of this.peers) if (peer !== this && peer.plot && peer.plot.left !== left) peer.draw();
    if (left === this.plot.left) return;
    this.layout(left);
    if (this.spec.equal) this.fit(this.view);
  }

  paint() {
    const { pen, spec } = this;
    this.box.style.touchAction = this.zoomed && spec.equal ? "none" : "pan-y";
    this.settle();
    pen.clearRect(0, 0, this.size.width, this.size.height);
    paintGrid(pen, this);
    pen.save();
    pen.beginPath();
    pen.rect(this.plot.left, this.plot.top, this.plot.width, this.plot.height);
    pen.clip();
    paintSpans(pen, this);
    if (spec.kind === "heat") paintHeat(pen, this);
    for (const series of this.series) if (!series.hidden && series.x.length) paintSeries(pen, this, series);
    paintMarks(pen, this);
    this.paintPointer(pen);
    pen.restore();
  }

  paintPointer(pen) {
    const { plot, drag, cursor } = this;
    if (drag) {
      pen.fillStyle = colour("select");
      const [x, y, width, height] = this.spec.equal
        ? [drag.x0, drag.y0, drag.x1 - drag.x0, drag.y1 - drag.y0]
        : [drag.x0, plot.top, drag.x1 - drag.x0, plot.height];
      pen.fillRect(x, y, width, height);
    } else if (cursor !== null && !this.spec.equal) {
      pen.strokeStyle = colour("axis");
      const x = Math.round(this.px(cursor)) + 0.5;
      line(pen, x, plot.top, x, plot.top + plot.height);
    }
    if (this.spot) {
      pen.strokeStyle = colour("ink");
      pen.beginPath();
      pen.arc(this.px(this.spot[0]), this.py(this.spot[1]), 5, 0, 7);
      pen.stroke();
    }
  }
}
