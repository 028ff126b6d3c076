// Zoom and values for the figures of this page, which are complete without this script.
"use strict";

(() => {
  const SVG = "http://www.w3.org/2000/svg";
  // Lengths in units of the drawings: a quarter of a pixel at original size.
  const LABELS = { left: 220, top: 16, right: 64, bottom: 92 };
  const TEXT = { size: 48, gap: 24 };
  const DRAG = 24;
  const MIN_SPAN = 1e-4;

  const element = (name, attributes, parent) => {
    const made = document.createElementNS(SVG, name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    parent?.append(made);
    return made;
  };

  const write = (text, attributes, parent) => {
    const family = parent.ownerSVGElement.querySelector("text")?.getAttribute("font-family") ?? "sans-serif";
    const made = element("text", { fill: "#222222", "font-size": TEXT.size, "font-family": family, ...attributes }, parent);
    made.textContent = text;
  };

  /** Returns round numbers between two ends, and the number of decimals that distinguishes them. */
  const ticks = ([low, high], wanted) => {
    const raw = (high - low) / wanted;
    const power = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].map((digit) => digit * power).find((candidate) => candidate >= raw * 0.999);
    const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
    const first = Math.ceil(low / step - 1e-6);
    const count = Math.floor(high / step + 1e-6) - first + 1;
    const values = Array.from({ length: Math.max(0, count) }, (_, k) => (first + k) * step);
    const label = (value) => {
      const shown = Math.abs(value) < step / 2 ? 0 : value;
      return (decimals > 5 ? shown.toExponential(1) : shown.toFixed(decimals)).replaceAll("-", "−");
    };
    return { values, label };
  };

  const significant = (value) => {
    const size = Math.abs(value);
    const text = size !== 0 && (size < 1e-3 || size >= 1e5) ? value.toExponential(2) : String(Number(value.toPrecision(5)));
    return text.replaceAll("-", "−");
  };

  /** Prints `F_x` as F with an index, like the rest of the page. */
  const indexed = (text) => {
    const pieces = text.split(/(?<![\p{L}\p{N}_])(\p{L})_([\p{L}\p{N}])(?![\p{L}\p{N}_])/u);
    return pieces.map((piece, i) => {
      if (i % 3 !== 2) return piece;
      const index = document.createElement("sub");
      index.textContent = piece;
      return index;
    });
  };

  /** One set of axes with its curves: points as x0, y0, x1, y1, … */
  class Panel {
    constructor(svg, data, index) {
      Object.assign(this, data);
      this.svg = svg;
      this.shown = this.window;
      this.clip = `clip-${svg.closest("figure").id}-${index}`;
    }

    has({ x, y }) {
      return x >= this.x[0] && x <= this.x[1] && y >= this.y[0] && y <= this.y[1];
    }

    value(x) {
      const [from, to] = this.shown;
      return from + ((x - this.x[0]) / (this.x[1] - this.x[0])) * (to - from);
    }

    place(value) {
      const [from, to] = this.shown;
      return this.x[0] + ((value - from) / (to - from)) * (this.x[1] - this.x[0]);
    }

    height(value, [low, high] = this.range()) {
      return this.y[1] - ((value - low) / (high - low)) * (this.y[1] - this.y[0]);
    }

    get zoomed() {
      return this.shown[0] > this.window[0] || this.shown[1] < this.window[1];
    }

    /** Returns the range of the vertical axis: the whole range, or the range of the visible part. */
    range() {
      if (!this.zoomed) return this.y_range;
      let [low, high] = [Infinity, -Infinity];
      const take = (value) => {
        if (value !== null) [low, high] = [Math.min(low, value), Math.max(high, value)];
      };
      for (const { points } of this.curves) {
        for (let i = 0; i < points.length; i += 2) {
          if (points[i] >= this.shown[0] && points[i] <= this.shown[1]) take(points[i + 1]);
        }
        this.shown.forEach((end) => take(this.at(points, end)));
      }
      if (!(high > low)) return low === high ? [low - 1, high + 1] : this.y_range;
      const margin = 0.06 * (high - low);
      return [low - margin, high + margin];
    }

    /** Returns the value of a curve at a time; null outside of the curve. */
    at(points, x) {
      let [low, high] = [0, points.length / 2 - 1];
      if (high < 0 || x < points[0] || x > points[2 * high]) return null;
      while (high - low > 1) {
        const middle = (low + high) >> 1;
        if (points[2 * middle] <= x) low = middle;
        else high = middle;
      }
      const [x0, y0, x1, y1] = points.slice(2 * low, 2 * low + 4);
      return x1 === undefined || x1 === x0 ? y0 : y0 + ((y1 - y0) * (x - x0)) / (x1 - x0);
    }

    show([from, to]) {
      const least = MIN_SPAN * (this.window[1] - this.window[0]);
      if (to - from < least) [from, to] = [(from + to - least) / 2, (from + to + least) / 2];
      this.shown = [Math.max(from, this.window[0]), Math.min(to, this.window[1])];
      this.drawn?.remove();
      this.drawn = undefined;
      if (this.zoomed) this.draw();
    }

    /** Draws the visible part over the picture. */
    draw() {
      const [[left, right], [top, bottom]] = [this.x, this.y];
      const group = element("g", { class: "live" }, this.svg);
      const area = { x: left, y: top, width: right - left, height: bottom - top };
      element("rect", {
        x: left - LABELS.left,
        y: top - LABELS.top,
        width: right - left + LABELS.left + LABELS.right,
        height: bottom - top + LABELS.top + LABELS.bottom,
        fill: "#FFFFFF",
      }, group);
      const clip = element("clipPath", { id: this.clip }, element("defs", {}, group));
      element("rect", area, clip);
      const range = this.range();
      const across = ticks(this.shown, 6);
      for (const value of across.values) {
        const x = this.place(value);
        element("line", { x1: x, x2: x, y1: top, y2: bottom, stroke: "#DDDDDD", "stroke-width": 3 }, group);
        write(across.label(value), { x, y: bottom + TEXT.gap + TEXT.size, "text-anchor": "middle" }, group);
      }
      const up = ticks(range, 6);
      for (const value of up.values) {
        const y = this.height(value, range);
        element("line", { x1: left, x2: right, y1: y, y2: y, stroke: "#DDDDDD", "stroke-width": 3 }, group);
        write(up.label(value), { x: left - TEXT.gap, y: y + TEXT.size / 3, "text-anchor": "end" }, group);
      }
      const curves = element("g", { "clip-path": `url(#${this.clip})`, fill: "none" }, group);
      for (const curve of this.curves) this.trace(curve, range, curves);
      const corner = `${left},${top} ${left},${bottom} ${right},${bottom}`;
      element("polyline", { points: corner, fill: "none", stroke: "#222222", "stroke-width": 4 }, group);
      this.drawn = group;
    }

    trace({ points, colour, width, dashed }, range, parent) {
      const path = [];
      for (let i = 0; i < points.length; i += 2) {
        path.push(`${this.place(points[i]).toFixed(1)},${this.height(points[i + 1], range).toFixed(1)}`);
      }
      const dashes = dashed ? { "stroke-dasharray": "24 16" } : {};
      element("polyline", { points: path.join(" "), stroke: colour, "stroke-width": width, ...dashes }, parent);
    }
  }

  /** A figure with its panels, pointer and keyboard events, and three buttons. */
  class Figure {
    constructor(figure) {
      this.card = figure.querySelector(".card");
      this.svg = figure.querySelector("svg");
      const data = JSON.parse(figure.querySelector("script").textContent);
      this.panels = data.map((panel, index) => new Panel(this.svg, panel, index));
      this.tip = document.createElement("div");
      this.tip.className = "tip";
      this.tip.setAttribute("role", "status");
      this.card.append(this.tip);
      this.card.tabIndex = 0;
      this.card.setAttribute("aria-description", "arrow keys read the curves, + and − zoom, 0 shows all");
      this.buttons();
      this.svg.addEventListener("pointermove", (event) => this.moved(event));
      this.svg.addEventListener("pointerdown", (event) => this.pressed(event));
      this.svg.addEventListener("pointerup", (event) => this.released(event));
      this.svg.addEventListener("pointercancel", () => this.cancel());
      this.svg.addEventListener("pointerleave", () => this.start || this.clear());
      this.svg.addEventListener("dblclick", () => this.whole());
      this.svg.addEventListener("wheel", (event) => this.rolled(event), { passive: false });
      this.card.addEventListener("keydown", (event) => this.key(event));
      this.card.addEventListener("blur", () => this.clear());
    }

    buttons() {
      const bar = document.createElement("div");
      bar.className = "zoom";
      const button = (text, title, action) => {
        const made = document.createElement("button");
        Object.assign(made, { type: "button", textContent: text, title });
        made.setAttribute("aria-label", title);
        made.addEventListener("click", action);
        bar.append(made);
        return made;
      };
      button("+", "zoom in", () => this.zoom(0.5));
      button("−", "zoom out", () => this.zoom(2));
      this.reset = button("all", "show all of it", () => this.whole());
      this.reset.disabled = true;
      this.card.append(bar);
    }

    point(event) {
      return new DOMPoint(event.clientX, event.clientY).matrixTransform(this.svg.getScreenCTM().inverse());
    }

    /** Panels with the same horizontal axis and range move together. */
    linked(panel) {
      return this.panels.filter((other) => String(other.window) === String(panel.window));
    }

    show(panel, part) {
      this.linked(panel).forEach((other) => other.show(part));
      this.reset.disabled = !this.panels.some((other) => other.zoomed);
      this.cursor ? this.read(this.cursor.panel, this.cursor.x) : this.clear();
    }

    /** Zooms around the time under the cursor, or around the middle. */
    zoom(factor, panel = this.cursor?.panel ?? this.panels[0], at = this.cursor?.x) {
      const [from, to] = panel.shown;
      const centre = at ?? (from + to) / 2;
      this.show(panel, [centre - factor * (centre - from), centre + factor * (to - centre)]);
    }

    whole() {
      this.panels.forEach((panel) => panel.show(panel.window));
      this.reset.disabled = true;
      this.clear();
    }

    moved(event) {
      const point = this.point(event);
      if (this.start) return this.select(point);
      const panel = this.panels.find((candidate) => candidate.has(point));
      panel ? this.read(panel, panel.value(point.x)) : this.clear();
    }

    pressed(event) {
      if (event.button !== 0) return;
      const point = this.point(event);
      const panel = this.panels.find((candidate) => candidate.has(point));
      if (!panel) return;
      this.start = { panel, x: point.x };
      this.svg.setPointerCapture(event.pointerId);
    }

    select(point) {
      const { panel, x } = this.start;
      const end = Math.min(Math.max(point.x, panel.x[0]), panel.x[1]);
      this.clear();
      if (Math.abs(end - x) < DRAG) return;
      const [from, to] = [Math.min(x, end), Math.max(x, end)];
      const area = { x: from, width: to - from, y: panel.y[0], height: panel.y[1] - panel.y[0] };
      this.mark = element("rect", { ...area, class: "selected" }, this.svg);
    }

    released(event) {
      if (!this.start) return;
      const { panel, x } = this.start;
      const end = Math.min(Math.max(this.point(event).x, panel.x[0]), panel.x[1]);
      this.cancel();
      if (Math.abs(end - x) >= DRAG) this.show(panel, [panel.value(Math.min(x, end)), panel.value(Math.max(x, end))]);
      else this.read(panel, panel.value(end));
    }

    cancel() {
      this.start = undefined;
      this.clear();
    }

    /** Without a modifier key, the wheel scrolls the page. */
    rolled(event) {
      if (!event.ctrlKey && !event.metaKey) return;
      const point = this.point(event);
      const panel = this.panels.find((candidate) => candidate.has(point));
      if (!panel) return;
      event.preventDefault();
      this.zoom(event.deltaY > 0 ? 1.25 : 0.8, panel, panel.value(point.x));
    }

    key(event) {
      if (event.target !== this.card || event.ctrlKey || event.altKey || event.metaKey) return;
      const actions = {
        ArrowLeft: () => this.step(-0.01),
        ArrowRight: () => this.step(0.01),
        ArrowUp: () => this.change(-1),
        ArrowDown: () => this.change(1),
        "+": () => this.zoom(0.5),
        "-": () => this.zoom(2),
        0: () => this.whole(),
        Escape: () => this.whole(),
      };
      if (!Object.hasOwn(actions, event.key)) return;
      event.preventDefault();
      actions[event.key]();
    }

    step(part) {
      const panel = this.cursor?.panel ?? this.panels[0];
      const [from, to] = panel.shown;
      const x = (this.cursor?.x ?? (from + to) / 2) + part * (to - from);
      this.read(panel, Math.min(Math.max(x, from), to));
    }

    change(by) {
      const index = this.panels.indexOf(this.cursor?.panel ?? this.panels[0]) + by;
      const panel = this.panels[Math.min(Math.max(index, 0), this.panels.length - 1)];
      const [from, to] = panel.shown;
      this.read(panel, Math.min(Math.max(this.cursor?.x ?? from, from), to));
    }

    /** Shows the value of every curve at a time. */
    read(panel, x) {
      this.clear();
      this.cursor = { panel, x };
      const range = panel.range();
      this.mark = element("g", { class: "cursor" }, this.svg);
      const place = panel.place(x);
      element("line", { x1: place, x2: place, y1: panel.y[0], y2: panel.y[1] }, this.mark);
      const rows = [];
      for (const { label, colour, points } of panel.curves) {
        const value = panel.at(points, x);
        if (value === null) continue;
        const cy = Math.min(Math.max(panel.height(value, range), panel.y[0]), panel.y[1]);
        element("circle", { cx: place, cy, r: 14, fill: colour }, this.mark);
        rows.push([colour, label, significant(value)]);
      }
      this.say(panel, x, rows, place);
    }

    say(panel, x, rows, place) {
      const [, name, unit = ""] = panel.x_label.match(/^(.*?)(?: \((.*)\))?$/);
      const head = document.createElement("b");
      head.textContent = `${name} ${significant(x)} ${unit}`;
      const lines = rows.map(([colour, label, value]) => {
        const line = document.createElement("div");
        const swatch = document.createElement("i");
        swatch.style.background = colour;
        const number = document.createElement("span");
        number.textContent = value;
        const name = document.createElement("span");
        name.append(...indexed(label));
        line.append(swatch, name, number);
        return line;
      });
      this.tip.replaceChildren(head, ...lines);
      const scale = this.svg.clientWidth / this.svg.viewBox.baseVal.width;
      const { offsetLeft, offsetTop } = { offsetLeft: this.svg.parentElement.clientLeft + 8, offsetTop: 8 };
      const right = place < (panel.x[0] + panel.x[1]) / 2;
      this.tip.style.display = "block";
      const left = right ? place * scale + offsetLeft + 14 : place * scale + offsetLeft - 14 - this.tip.offsetWidth;
      const most = this.card.scrollLeft + this.card.clientWidth - this.tip.offsetWidth - 2;
      this.tip.style.left = `${Math.max(this.card.scrollLeft + 2, Math.min(left, most))}px`;
      this.tip.style.top = `${panel.y[0] * scale + offsetTop + 4}px`;
    }

    clear() {
      this.mark?.remove();
      this.mark = undefined;
      this.cursor = undefined;
      this.tip.style.display = "none";
    }
  }

  document.querySelectorAll("figure").forEach((figure) => new Figure(figure));
})();
