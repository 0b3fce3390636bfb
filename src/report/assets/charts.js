// SPDX-License-Identifier: Apache-2.0
// Colours, axes, legends and the charts of lines and points (XyChart of src/report/page.h).
"use strict";
const sarblock = (function () {
  // Okabe and Ito's colours, which stay apart for colour-blind readers; cividis for a scale, dark for
  // what is weak.
  const colors = {
    ink: "#1c2126", blue: "#0072b2", sky: "#56b4e9", green: "#009e73", orange: "#d55e00",
    yellow: "#e69f00", purple: "#a8507f", grey: "#8a949c", pale: "#b9d3e4"};
  const cividis = [
    [0, 34, 78], [18, 53, 112], [59, 73, 108], [87, 93, 109], [112, 113, 115], [138, 134, 120],
    [165, 156, 116], [195, 179, 105], [225, 204, 85], [254, 232, 56]].reverse();
  const withAlpha = (hex, alpha) => hex + Math.round(alpha * 255).toString(16).padStart(2, "0");

  Chart.defaults.font.family = getComputedStyle(document.body).fontFamily;
  Chart.defaults.font.size = 12;
  Chart.defaults.color = "#5b6670";
  Chart.defaults.animation = false;
  Chart.defaults.maintainAspectRatio = false;
  Chart.defaults.devicePixelRatio = Math.max(2, window.devicePixelRatio || 1);
  Chart.defaults.plugins.legend.display = false;
  Chart.defaults.plugins.tooltip.backgroundColor = "#1c2126";

  function shown(value) {
    if (value === null || value === undefined) return "-";
    const size = Math.abs(value);
    if (size !== 0 && (size < 1e-4 || size >= 1e6)) return Number(value.toPrecision(3)).toExponential();
    return String(Number(value.toPrecision(4)));
  }

  function axis(spec) {
    const out = {
      type: spec.log ? "logarithmic" : "linear",
      title: {display: true, text: spec.label},
      grid: {color: "#e9edf0", drawTicks: false},
      border: {display: false},
      ticks: {maxRotation: 0, autoSkipPadding: 14, padding: 6}};
    out.ticks.includeBounds = false;
    if (spec.log) {
      // 1, 2 and 5 of each decade; over many decades the powers of ten alone.
      out.ticks.autoSkip = false;
      out.ticks.callback = shown;
      out.afterBuildTicks = (scale) => {
        const decades = Math.log10(scale.max / scale.min);
        const steps = decades > 3 ? [1] : [1, 2, 5];
        const every = Math.max(1, Math.ceil(decades / 7));
        scale.ticks = [];
        for (let p = Math.floor(Math.log10(scale.min)); p <= Math.ceil(Math.log10(scale.max)); ++p) {
          if (p % every !== 0) continue;
          steps.forEach((step) => {
            const value = step * Math.pow(10, p);
            if (value >= scale.min * 0.999 && value <= scale.max * 1.001) {
              scale.ticks.push({value: Number(value.toPrecision(3))});
            }
          });
        }
      };
    }
    if (spec.min !== undefined) out.min = spec.min;
    if (spec.max !== undefined) out.max = spec.max;
    return out;
  }

  const pairs = (xs, ys) => xs.map((x, i) => ({x: x, y: ys[i]}));

  // One series of data as one or two data sets of the library.
  function dataSets(series) {
    const color = colors[series.color] || series.color;
    const base = {
      label: series.label, names: series.names, written: series.written, data: pairs(series.x, series.y),
      borderColor: color, backgroundColor: color, borderWidth: 2, pointRadius: 0,
      pointHitRadius: 6, parsing: true};
    switch (series.style) {
      case "points": {
        const many = series.x.length > 400;
        return [Object.assign(base, {
          showLine: false, pointRadius: many ? 1.6 : 2.8, pointHoverRadius: 5, borderWidth: 0})];
      }
      case "dash":
        return [Object.assign(base, {borderDash: [6, 4]})];
      case "marks":
        return [Object.assign(base, {pointRadius: 3.5, borderWidth: 1.5})];
      case "steps":
        return [Object.assign(base, {
          stepped: "before", fill: "origin", borderWidth: 1, backgroundColor: withAlpha(color, 0.35)})];
      case "band": {
        const edge = {
          borderWidth: 0, pointRadius: 0, pointHitRadius: 0, label: "", borderColor: color,
          backgroundColor: withAlpha(color, 0.18)};
        return [
          Object.assign({}, edge, {data: pairs(series.x, series.low), fill: false}),
          Object.assign({}, edge, {
            data: pairs(series.x, series.high), fill: "-1", label: series.label, band: true})];
      }
      case "bars": {
        const bars = [];
        series.x.forEach((x, i) => {
          bars.push({x: x, y: series.low[i]}, {x: x, y: series.high[i]}, {x: x, y: NaN});
        });
        return [
          Object.assign({}, base, {data: bars, label: "", borderWidth: 1.2, pointHitRadius: 0}),
          Object.assign(base, {showLine: false, pointRadius: 3.2})];
      }
      default:
        return [base];
    }
  }

  // A small drawing of a data set for the legend.
  function swatch(set) {
    const color = set.borderColor;
    let inner;
    if (set.band) {
      inner = `<rect x="0" y="2" width="18" height="8" fill="${set.backgroundColor}"/>`;
    } else if (set.showLine === false || set.pointStyle) {
      inner = set.pointStyle === "triangle"
        ? `<path d="M9 1 L14 11 L4 11 Z" fill="none" stroke="${color}" stroke-width="1.5"/>`
        : set.pointStyle === "rect"
          ? `<rect x="5" y="2" width="8" height="8" fill="none" stroke="${color}" stroke-width="1.5"/>`
          : `<circle cx="9" cy="6" r="3" fill="${typeof color === "string" ? color : "#5b6670"}"/>`;
    } else {
      const dash = set.borderDash ? ' stroke-dasharray="5 3"' : "";
      inner = `<path d="M0 6 L18 6" stroke="${color}" stroke-width="2"${dash}/>`;
    }
    return `<svg width="18" height="12" aria-hidden="true">${inner}</svg>`;
  }

  // A legend in HTML above a chart. An entry has a name, the data set that its swatch shows, and
  // `toggle` where it can be switched, `on` at first. Small charts side by side share one.
  function addLegend(canvas, entries) {
    const small = canvas.closest("figure.small");
    const shared = small && small.parentElement.previousElementSibling;
    const box = shared && shared.className === "legend" ? shared : document.createElement("div");
    box.className = "legend";
    (small ? small.parentElement : canvas.parentElement).before(box);
    entries.forEach((entry) => {
      if ([...box.children].some((label) => label.textContent === entry.name)) return;
      const label = document.createElement("label");
      if (entry.toggle) {
        const input = document.createElement("input");
        input.type = "checkbox";
        input.checked = entry.on;
        input.addEventListener("change", () => entry.toggle(input.checked));
        label.append(input);
      }
      if (entry.set) label.insertAdjacentHTML("beforeend", swatch(entry.set));
      label.append(entry.name);
      box.append(label);
    });
  }

  const tooltip = {
    callbacks: {
      title: () => "",
      label: (item) => {
        const set = item.dataset;
        const name = set.names ? set.names[item.dataIndex] + ": " : "";
        const value = set.values
          ? `${set.valueLabel} ${shown(set.values[item.dataIndex])}`
          : `${shown(item.raw.x)}, ${shown(item.raw.y)}`;
        return `${set.names ? name : (set.label ? set.label + ": " : "")}${value}`;
      }}};

  // Places for texts that do not cover each other.
  function textPlaces(area) {
    const taken = [];
    return (x, y, width, height) => {
      const box = {x0: x - 2, x1: x + width + 2, y0: y - height, y1: y + 1};
      const free = box.x0 >= area.left - 1 && box.x1 <= area.right + 1 && box.y0 >= area.top - 1 &&
        box.y1 <= area.bottom + 1 &&
        !taken.some((t) => t.x0 < box.x1 && box.x0 < t.x1 && t.y0 < box.y1 && box.y0 < t.y1);
      if (free) taken.push(box);
      return free;
    };
  }

  // The names of the points of `sets` beside them, as many as there is room for; their number.
  function writeNames(chart, sets, size) {
    const ctx = chart.ctx;
    const free = textPlaces(chart.chartArea);
    let written = 0;
    ctx.save();
    ctx.font = `${size}px ${Chart.defaults.font.family}`;
    ctx.lineWidth = 3;
    ctx.strokeStyle = "rgba(255,255,255,0.85)";
    ctx.fillStyle = colors.ink;
    sets.forEach((set) => set.data.forEach((point, i) => {
      if (!set.names || !set.names[i] || !Number.isFinite(point.y)) return;
      const x = chart.scales.x.getPixelForValue(point.x);
      const y = chart.scales.y.getPixelForValue(point.y);
      const area = chart.chartArea;
      if (x < area.left || x > area.right || y < area.top || y > area.bottom) return;
      const width = ctx.measureText(set.names[i]).width;
      const beside = [[x + 6, y + 4], [x - 6 - width, y + 4]];
      const over = [[x - width / 2, y - 7], [x - width / 2, y + 7 + size], [x - width, y - 7], [x - width, y + 7 + size]];
      const places = set.showLine === false ? beside.concat(over) : over.concat(beside);
      const place = places.find((p) => free(p[0], p[1], width, size));
      if (!place) return;
      ctx.strokeText(set.names[i], place[0], place[1]);
      ctx.fillText(set.names[i], place[0], place[1]);
      ++written;
    }));
    ctx.restore();
    return written;
  }

  function drawNames(chart) {
    return writeNames(chart, chart.data.datasets.filter((set) => set.written), 11);
  }

  function drawXy(canvas, spec) {
    const sets = spec.series.flatMap(dataSets);
    // Later series are drawn on top of earlier ones.
    sets.forEach((set, i) => { set.order = sets.length - i; });
    const chart = new Chart(canvas, {
      type: "line",
      data: {datasets: sets},
      options: {
        scales: {x: axis(spec.x), y: axis(spec.y)},
        elements: {line: {tension: 0}},
        interaction: {mode: "nearest", intersect: true},
        plugins: {tooltip: tooltip, filler: {propagate: false}}},
      plugins: [{id: "names", afterDatasetsDraw: (c) => { c.labelled = drawNames(c); }}]});
    const entries = new Map();
    sets.filter((set) => set.label).forEach((set) => entries.set(set.label, {name: set.label, set: set}));
    if (entries.size > 1) addLegend(canvas, [...entries.values()]);
    return {
      data: sets.reduce((sum, set) => sum + set.data.length, 0),
      series: entries.size,
      labels: chart.labelled || 0};
  }

  return {
    colors: colors, cividis: cividis, withAlpha: withAlpha, shown: shown, axis: axis, tooltip: tooltip,
    addLegend: addLegend, textPlaces: textPlaces, writeNames: writeNames, drawXy: drawXy};
})();
