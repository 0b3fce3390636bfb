// SPDX-License-Identifier: Apache-2.0
// The map of a block (MapChart of src/report/page.h): equal scales, zoom and pan, and over the data
// a graticule, north, a scale bar and the key of the error ellipses.
"use strict";
const sarblockMap = (function () {
  const {colors, cividis, withAlpha, shown} = sarblock;

  function flatPairs(list) {
    const out = [];
    for (let i = 0; i < list.length; i += 2) out.push({x: list[i], y: list[i + 1]});
    return out;
  }

  // Colour of a value between the ends of its scale; beyond them the colour of the end.
  function colorOf(spec) {
    const logarithmic = spec.log && spec.low > 0;
    const to = logarithmic ? Math.log : (v) => v;
    const ramp = spec.weakLow ? [...cividis].reverse() : cividis;
    const span = to(spec.high) - to(spec.low);
    return (value) => {
      if (value === null || (logarithmic && !(value > 0))) return "#ffffff";
      const part = span > 0 ? Math.min(1, Math.max(0, (to(value) - to(spec.low)) / span)) : 0;
      const at = part * (ramp.length - 1);
      const k = Math.min(ramp.length - 2, Math.floor(at));
      return `rgb(${ramp[k].map((c, i) => Math.round(c + (at - k) * (ramp[k + 1][i] - c))).join(",")})`;
    };
  }

  function extent(points) {
    const box = {x0: Infinity, x1: -Infinity, y0: Infinity, y1: -Infinity};
    points.forEach((p) => {
      if (!Number.isFinite(p.x) || !Number.isFinite(p.y)) return;
      box.x0 = Math.min(box.x0, p.x);
      box.x1 = Math.max(box.x1, p.x);
      box.y0 = Math.min(box.y0, p.y);
      box.y1 = Math.max(box.y1, p.y);
    });
    return box;
  }

  // Flight paths far away (orbits) would make the block a dot: then the map ends at the block.
  function wholeView(points, swaths, tracks) {
    const block = extent(points);
    const whole = extent(points.concat(swaths, tracks));
    const size = (b) => Math.max(b.x1 - b.x0, b.y1 - b.y0);
    const box = size(whole) <= 2.2 * size(block) ? whole : extent(points.concat(swaths));
    return size(box) <= 2.2 * size(block) ? box : block;
  }

  // What part of the plane is seen: the whole block, or what a reader has zoomed and moved to.
  class View {
    constructor(box) {
      this.box = box;
      this.reset();
    }
    reset() {
      this.zoom = 1;
      this.x = 0.5 * (this.box.x0 + this.box.x1);
      this.y = 0.5 * (this.box.y0 + this.box.y1);
    }
    // Size of a pixel in units of the map; equal scales on both axes, whatever the canvas is.
    perPixel(area) {
      const width = Math.max(1, area.right - area.left), height = Math.max(1, area.bottom - area.top);
      return 1.06 / this.zoom *
        Math.max((this.box.x1 - this.box.x0) / width, (this.box.y1 - this.box.y0) / height, 1e-12);
    }
    // Gives both axes their limits; true where they changed.
    fit(chart) {
      const area = chart.chartArea, per = this.perPixel(area);
      const half = {x: 0.5 * per * (area.right - area.left), y: 0.5 * per * (area.bottom - area.top)};
      let changed = false;
      ["x", "y"].forEach((name) => {
        const scale = chart.options.scales[name];
        const min = this[name] - half[name], max = this[name] + half[name];
        if (Math.abs((scale.min ?? 1e300) - min) > 0.3 * per || Math.abs((scale.max ?? 1e300) - max) > 0.3 * per) {
          scale.min = min;
          scale.max = max;
          changed = true;
        }
      });
      return changed;
    }
    // Zooms by a factor about a place of the canvas, which stays where it is.
    zoomAt(chart, factor, px, py) {
      const area = chart.chartArea, per = this.perPixel(area);
      const x = this.x + (px - 0.5 * (area.left + area.right)) * per;
      const y = this.y - (py - 0.5 * (area.top + area.bottom)) * per;
      const zoom = Math.min(2000, Math.max(0.5, this.zoom * factor));
      const part = this.zoom / zoom;
      this.zoom = zoom;
      this.x = x + (this.x - x) * part;
      this.y = y + (this.y - y) * part;
    }
    move(chart, dx, dy) {
      const per = this.perPixel(chart.chartArea);
      this.x -= dx * per;
      this.y += dy * per;
    }
  }

  // The largest of 1, 2, 5 times a power of ten that is not above a value.
  function roundDown125(value) {
    const power = Math.pow(10, Math.floor(Math.log10(value)));
    return [5, 2, 1].map((k) => k * power).find((v) => v <= value * 1.000001) || power;
  }

  // 0.5 m, 20 m, 5 km
  function lengthText(metres) {
    const round = (v) => String(Number(v.toPrecision(3)));
    return metres >= 1000 ? `${round(metres / 1000)} km`
      : metres >= 1 ? `${round(metres)} m`
      : metres >= 0.01 ? `${round(metres * 100)} cm` : `${round(metres * 1000)} mm`;
  }

  // Error ellipses and errors of check points, enlarged so that the median ellipse is a twentieth of
  // the picture; one ellipse a cell of a grid over the picture, so that they do not cover each other.
  class Enlarged {
    constructor(spec) {
      this.spec = spec;
      const major = [];
      for (let i = 0; i < spec.ellipses.length; i += 5) major.push(spec.ellipses[i + 2]);
      major.sort((a, b) => a - b);
      this.median = major.length > 0 ? major[Math.floor(major.length / 2)] : NaN;
      this.ellipses = major.length > 0;
      this.errors = spec.errors.length > 0;
    }
    get any() { return this.spec.ellipses.length > 0; }
    draw(chart) {
      if (!this.any) return;
      const {ctx, chartArea: area, scales: {x, y}} = chart;
      const pixels = (area.right - area.left) / (x.max - x.min);
      const size = Math.max(x.max - x.min, y.max - y.min);
      this.times = roundDown125(size / 40 / this.median);
      this.drawn = 0;
      const at = (list, i) => [x.getPixelForValue(list[i]), y.getPixelForValue(list[i + 1])];
      const inside = ([px, py]) => px >= area.left && px <= area.right && py >= area.top && py <= area.bottom;
      ctx.save();
      ctx.beginPath();
      ctx.rect(area.left, area.top, area.right - area.left, area.bottom - area.top);
      ctx.clip();
      ctx.strokeStyle = colors.ink;
      ctx.lineWidth = 1;
      const taken = new Set(), list = this.spec.ellipses, cell = 11 / size;
      for (let i = 0; this.ellipses && i < list.length; i += 5) {
        const key = `${Math.floor((list[i] - x.min) * cell)} ${Math.floor((list[i + 1] - y.min) * cell)}`;
        const place = at(list, i);
        if (taken.has(key) || !inside(place)) continue;
        taken.add(key);
        const scale = this.times * pixels;
        ctx.beginPath();
        // Azimuths count from north clockwise, angles of the canvas from east clockwise.
        ctx.ellipse(place[0], place[1], scale * list[i + 2], Math.max(0.3, scale * list[i + 3]),
          list[i + 4] - Math.PI / 2, 0, 2 * Math.PI);
        ctx.stroke();
        ++this.drawn;
      }
      ctx.strokeStyle = colors.orange;
      ctx.lineWidth = 1.8;
      const errors = this.spec.errors;
      for (let i = 0; this.errors && i < errors.length; i += 4) {
        const place = at(errors, i);
        ctx.beginPath();
        ctx.moveTo(place[0], place[1]);
        ctx.lineTo(place[0] + this.times * pixels * errors[i + 2], place[1] - this.times * pixels * errors[i + 3]);
        ctx.stroke();
      }
      ctx.restore();
    }
  }

  function text(ctx, words, x, y, align) {
    ctx.textAlign = align;
    ctx.lineWidth = 3;
    ctx.strokeStyle = "rgba(255,255,255,0.9)";
    ctx.strokeText(words, x, y);
    ctx.fillText(words, x, y);
  }

  function drawNorth(chart) {
    const {ctx, chartArea: area} = chart;
    const x = area.right - 18, y = area.top + 10;
    ctx.beginPath();
    ctx.moveTo(x, y);
    ctx.lineTo(x + 6, y + 22);
    ctx.lineTo(x, y + 17);
    ctx.lineTo(x - 6, y + 22);
    ctx.closePath();
    ctx.fill();
    text(ctx, "N", x, y + 36, "center");
  }

  // A bar of a round length, and above it a circle of a round standard deviation, enlarged as the
  // ellipses are.
  function drawKeys(chart, enlarged, unit) {
    const {ctx, chartArea: area, scales: {x}} = chart;
    const pixels = (area.right - area.left) / (x.max - x.min);
    const length = roundDown125((area.right - area.left) / 4 / pixels);
    const left = area.left + 12, base = area.bottom - 12;
    const words = lengthText(length * unit);
    const enlargedWords = [];
    let radius = 0;
    if (enlarged.any && (enlarged.ellipses || enlarged.errors)) {
      const sigma = roundDown125(enlarged.median * 1.2);
      radius = sigma * enlarged.times * pixels;
      enlargedWords.push(`${lengthText(sigma * unit)}, one sigma`, `(enlarged ${Math.round(enlarged.times).toLocaleString("en").replaceAll(",", "\u202f")} times)`);
    }
    const high = 24 + (radius > 0 ? 2 * Math.max(radius, 13) + 8 : 0);
    const wide = Math.max(length * pixels + 8 + ctx.measureText(words).width,
      radius > 0 ? 2 * radius + 8 + Math.max(...enlargedWords.map((w) => ctx.measureText(w).width)) : 0);
    ctx.fillStyle = "rgba(255,255,255,0.82)";
    ctx.fillRect(left - 6, base - high + 8, wide + 12, high);
    ctx.fillStyle = ctx.strokeStyle = colors.ink;
    ctx.lineWidth = 1.4;
    ctx.beginPath();
    ctx.moveTo(left, base - 5);
    ctx.lineTo(left, base);
    ctx.lineTo(left + length * pixels, base);
    ctx.lineTo(left + length * pixels, base - 5);
    ctx.stroke();
    text(ctx, words, left + length * pixels + 6, base, "left");
    if (radius > 0) {
      const middle = base - 18 - Math.max(radius, 13);
      ctx.strokeStyle = colors.ink;
      ctx.lineWidth = 1;
      ctx.beginPath();
      ctx.arc(left + radius, middle, radius, 0, 2 * Math.PI);
      ctx.stroke();
      enlargedWords.forEach((line, i) => text(ctx, line, left + 2 * radius + 6, middle - 2 + 14 * i, "left"));
    }
    return words;
  }

  function drawGraticule(chart, lines) {
    const {ctx, chartArea: area, scales: {x, y}} = chart;
    ctx.save();
    ctx.beginPath();
    ctx.rect(area.left, area.top, area.right - area.left, area.bottom - area.top);
    ctx.clip();
    ctx.font = `11px ${Chart.defaults.font.family}`;
    ctx.fillStyle = "#5b6670";
    const free = sarblock.textPlaces(area);
    lines.forEach((line) => {
      ctx.strokeStyle = "#c3ccd3";
      ctx.lineWidth = 1;
      const places = flatPairs(line.xy).map((p) => [x.getPixelForValue(p.x), y.getPixelForValue(p.y)]);
      ctx.beginPath();
      places.forEach((p, i) => (i === 0 ? ctx.moveTo(p[0], p[1]) : ctx.lineTo(p[0], p[1])));
      ctx.stroke();
      // The name where the line crosses the border of the picture, unless another stands there.
      const inside = (p) => p[0] > area.left && p[0] < area.right && p[1] > area.top && p[1] < area.bottom;
      if (places.length > 0 && inside(places[0])) places.reverse();
      const first = places.findIndex(inside);
      if (first < 0) return;
      let [px, py] = places[first];
      for (let k = 0, out = places[Math.max(0, first - 1)]; k < 12; ++k) {
        const half = [0.5 * (px + out[0]), 0.5 * (py + out[1])];
        if (inside(half)) { [px, py] = half; } else { out = half; }
      }
      const width = ctx.measureText(line.name).width;
      px = Math.min(Math.max(px + 3, area.left + 3), area.right - width - 3);
      py = Math.min(Math.max(py - 3, area.top + 12), area.bottom - 4);
      if (free(px, py, width, 11)) text(ctx, line.name, px, py, "left");
    });
    ctx.restore();
  }

  function legendEntries(chart, spec, sets, state) {
    const entries = [];
    const groups = new Map();
    sets.forEach((set, i) => {
      if (!groups.has(set.group)) groups.set(set.group, []);
      groups.get(set.group).push(i);
    });
    groups.forEach((members, name) => entries.push({
      name: name, set: sets[members[0]], on: true,
      toggle: (on) => {
        members.forEach((i) => chart.setDatasetVisibility(i, on));
        chart.update("none");
      }}));
    const line = (color) => ({borderColor: color});
    const add = (name, set, holder, key, on) => entries.push({
      name: name, set: set, on: on,
      toggle: (now) => {
        holder[key] = now;
        chart.update("none");
      }});
    if (state.enlarged.any) add("error ellipses", line(colors.ink), state.enlarged, "ellipses", true);
    if (state.enlarged.any && spec.errors.length > 0) {
      add("errors of check points", line(colors.orange), state.enlarged, "errors", true);
    }
    if (spec.graticule.length > 0) add("graticule", line("#c3ccd3"), state, "graticule", true);
    add("names", null, state, "names", false);
    return entries;
  }

  function addHandling(chart, canvas, view) {
    let waiting = false;
    const draw = () => {
      if (waiting) return;
      waiting = true;
      requestAnimationFrame(() => {
        waiting = false;
        chart.update("none");
      });
    };
    const box = document.createElement("div");
    box.className = "zoom";
    const middle = () => [0.5 * (chart.chartArea.left + chart.chartArea.right), 0.5 * (chart.chartArea.top + chart.chartArea.bottom)];
    const zoom = (factor, px, py) => {
      view.zoomAt(chart, factor, px ?? middle()[0], py ?? middle()[1]);
      draw();
    };
    const whole = () => {
      view.reset();
      draw();
    };
    [["+", "zoom in", () => zoom(1.6)], ["\u2212", "zoom out", () => zoom(1 / 1.6)], ["\u2922", "whole block", whole]]
      .forEach(([sign, name, act]) => {
        const button = document.createElement("button");
        button.type = "button";
        button.textContent = sign;
        button.title = name;
        button.setAttribute("aria-label", name);
        button.addEventListener("click", act);
        box.append(button);
      });
    canvas.parentElement.append(box);
    canvas.tabIndex = 0;
    canvas.style.touchAction = "pan-y";
    // The page scrolls under the pointer; with Ctrl, or once the map was clicked, the wheel zooms.
    canvas.addEventListener("wheel", (event) => {
      if (!event.ctrlKey && !event.metaKey && document.activeElement !== canvas) return;
      event.preventDefault();
      zoom(Math.exp(-0.002 * event.deltaY), event.offsetX, event.offsetY);
    }, {passive: false});
    canvas.addEventListener("dblclick", (event) => zoom(2, event.offsetX, event.offsetY));
    canvas.addEventListener("keydown", (event) => {
      const act = {
        "+": () => zoom(1.6), "=": () => zoom(1.6), "-": () => zoom(1 / 1.6), "0": whole,
        ArrowLeft: () => view.move(chart, 60, 0), ArrowRight: () => view.move(chart, -60, 0),
        ArrowUp: () => view.move(chart, 0, 60), ArrowDown: () => view.move(chart, 0, -60)}[event.key];
      if (!act) return;
      event.preventDefault();
      act();
      draw();
    });
    const fingers = new Map();
    canvas.addEventListener("pointerdown", (event) => {
      fingers.set(event.pointerId, [event.offsetX, event.offsetY]);
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
      const before = fingers.get(event.pointerId);
      if (!before) return;
      const now = [event.offsetX, event.offsetY];
      const other = [...fingers.entries()].find(([id]) => id !== event.pointerId);
      if (other) {
        const reach = (p) => Math.max(10, Math.hypot(p[0] - other[1][0], p[1] - other[1][1]));
        zoom(reach(now) / reach(before), other[1][0], other[1][1]);
      } else {
        view.move(chart, now[0] - before[0], now[1] - before[1]);
      }
      fingers.set(event.pointerId, now);
      draw();
    });
    ["pointerup", "pointercancel"].forEach((name) => canvas.addEventListener(name, (event) => fingers.delete(event.pointerId)));
  }

  // The choice of what colours the points, and its scale.
  function addColours(chart, canvas, spec, pointSet) {
    const bar = document.createElement("div");
    bar.className = "scale";
    const select = document.createElement("select");
    select.setAttribute("aria-label", "colour of the points");
    spec.values.forEach((value, i) => select.add(new Option(value.label, i)));
    select.value = spec.shown;
    const name = document.createElement("span");
    name.className = "printed";
    const low = document.createElement("span");
    const ramp = document.createElement("i");
    const high = document.createElement("span");
    bar.append(select, name, low, ramp, high);
    canvas.parentElement.before(bar);
    const colour = () => {
      const value = spec.values[Number(select.value)];
      const color = colorOf({log: spec.log, ...value});
      const stops = (value.weakLow ? [...cividis].reverse() : cividis).map((c) => `rgb(${c.join(",")})`);
      ramp.style.background = `linear-gradient(to right, ${stops.join(",")})`;
      name.textContent = value.label;
      low.textContent = (value.least < value.low ? "below " : "") + shown(value.low);
      high.textContent = shown(value.high) + (value.most > value.high ? ` and above (largest ${shown(value.most)})` : "");
      pointSet.pointBackgroundColor = value.of.map(color);
      pointSet.values = value.of;
      pointSet.valueLabel = value.label;
      chart.update("none");
    };
    select.addEventListener("change", colour);
    colour();
  }

  function draw(canvas, spec) {
    const points = flatPairs(spec.points);
    const swaths = spec.swaths.map((s) => flatPairs(s.xy));
    const tracks = spec.tracks.map((t) => flatPairs(t.xy));
    const sets = [];
    const mark = (list, names, label, style, color) => {
      if (list.length === 0) return;
      sets.push({
        label: label, group: label, names: names, data: flatPairs(list), showLine: false,
        pointStyle: style, pointRadius: 6, pointBorderWidth: 1.8, borderColor: color,
        pointBorderColor: color, pointBackgroundColor: "rgba(255,255,255,0.25)"});
    };
    mark(spec.control, spec.controlNames, "control", "triangle", colors.orange);
    mark(spec.checks, spec.checkNames, "check", "rect", colors.ink);
    const pointSet = {
      label: "points", group: "points", names: spec.names, data: points, showLine: false,
      pointRadius: points.length > 2000 ? 2 : 3.4, pointBorderWidth: 0, borderColor: "#5b6670"};
    sets.push(pointSet);
    tracks.forEach((track, i) => {
      sets.push({
        label: spec.tracks[i].name, group: "flight paths", data: track, borderColor: colors.blue,
        borderWidth: 1.4, pointRadius: 0, pointHitRadius: 4,
        names: track.map(() => "pass " + spec.tracks[i].name)});
    });
    const fillAlpha = Math.max(0.03, Math.min(0.12, 0.5 / Math.max(1, swaths.length)));
    swaths.forEach((swath, i) => {
      sets.push({
        label: spec.swaths[i].name, group: "swaths", data: swath, borderColor: withAlpha("#56b4e9", 0.55),
        backgroundColor: withAlpha("#56b4e9", fillAlpha), fill: "shape", borderWidth: 0.8,
        pointRadius: 0, pointHitRadius: 0});
    });
    const view = new View(wholeView(points, swaths.flat(), tracks.flat()));
    // As high as the block is, within the reach of a screen.
    const width = canvas.parentElement.clientWidth;
    const shape = (view.box.y1 - view.box.y0) / Math.max(1e-12, view.box.x1 - view.box.x0);
    const height = Math.min(Math.max(shape * (width - 70) + 60, 280), Math.max(380, 0.72 * width));
    canvas.parentElement.style.height = `${Math.round(height)}px`;
    const state = {enlarged: new Enlarged(spec), graticule: true, names: false, written: 0, bar: ""};
    const axis = () => ({...sarblock.axis({label: spec.unit}), grid: {display: spec.graticule.length === 0, color: "#e9edf0", drawTicks: false}});
    const chart = new Chart(canvas, {
      type: "line",
      data: {datasets: sets},
      options: {
        scales: {x: axis(), y: axis()},
        elements: {line: {tension: 0}},
        interaction: {mode: "nearest", intersect: true},
        plugins: {tooltip: sarblock.tooltip, filler: {propagate: false}}},
      plugins: [{
        id: "view",
        afterLayout: (c) => {
          if (c.fitting) return;
          c.fitting = true;
          if (view.fit(c)) c.update("none");
          c.fitting = false;
        },
        beforeDatasetsDraw: (c) => {
          if (state.graticule) drawGraticule(c, spec.graticule);
        },
        afterDatasetsDraw: (c) => {
          state.enlarged.draw(c);
          const named = [0, 1, 2].map((i) => sets[i]).filter((set, i) => set && set.names && set.group !== "flight paths" && c.isDatasetVisible(i));
          state.written = state.names ? sarblock.writeNames(c, named, 11) : 0;
          c.ctx.save();
          c.ctx.font = `12px ${Chart.defaults.font.family}`;
          c.ctx.fillStyle = c.ctx.strokeStyle = colors.ink;
          drawNorth(c);
          state.bar = drawKeys(c, state.enlarged, spec.unitMetres);
          c.ctx.restore();
        }}]});
    addHandling(chart, canvas, view);
    addColours(chart, canvas, spec, pointSet);
    sarblock.addLegend(canvas, legendEntries(chart, spec, sets, state));

    // What the self-check tells: the picture as it is, a zoomed one with names, and the first again.
    const told = () => ({
      width: chart.scales.x.max - chart.scales.x.min, bar: state.bar, ellipses: state.enlarged.drawn || 0,
      enlarged: state.enlarged.times || 0, names: state.written});
    const whole = told();
    state.names = true;
    view.zoomAt(chart, 4, 0.5 * (chart.chartArea.left + chart.chartArea.right), 0.5 * (chart.chartArea.top + chart.chartArea.bottom));
    chart.update("none");
    const near = told();
    state.names = false;
    view.reset();
    chart.update("none");
    return {data: points.length, whole: whole, near: near, again: told()};
  }

  return {draw: draw};
})();
