// SPDX-License-Identifier: Apache-2.0
// Draws the charts that the page's data block describes (src/report/charts.h) and writes into
// #selfcheck what was drawn and which errors occurred.
"use strict";
(function () {
  const check = {charts: [], errors: []};
  const note = () => {
    document.getElementById("selfcheck").textContent = JSON.stringify(check);
  };
  window.addEventListener("error", (event) => {
    check.errors.push(String(event.message));
    note();
  });

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
    if (size !== 0 && (size < 1e-4 || size >= 1e6)) return value.toExponential(2);
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
      label: series.label, names: series.names, data: pairs(series.x, series.y),
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

  // A legend in HTML above the chart: every entry switches its data sets, which share a group.
  function addLegend(chart, canvas, switches) {
    const groups = new Map();
    chart.data.datasets.forEach((set, i) => {
      if (!set.group && !set.label) return;
      const name = set.group || set.label;
      if (!groups.has(name)) groups.set(name, []);
      groups.get(name).push(i);
    });
    if (groups.size < 2 && !switches) return;
    const box = document.createElement("div");
    box.className = "legend";
    groups.forEach((members, name) => {
      const label = document.createElement("label");
      if (switches) {
        const input = document.createElement("input");
        input.type = "checkbox";
        input.checked = true;
        input.addEventListener("change", () => {
          members.forEach((i) => chart.setDatasetVisibility(i, input.checked));
          chart.update();
        });
        label.append(input);
      }
      label.insertAdjacentHTML("beforeend", swatch(chart.data.datasets[members[members.length - 1]]));
      label.append(name);
      box.append(label);
    });
    canvas.parentElement.before(box);
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
        plugins: {tooltip: tooltip, filler: {propagate: false}}}});
    addLegend(chart, canvas, false);
    return sets.reduce((sum, set) => sum + set.data.length, 0);
  }

  function flatPairs(list) {
    const out = [];
    for (let i = 0; i < list.length; i += 2) out.push({x: list[i], y: list[i + 1]});
    return out;
  }
  // Several outlines as one data set: a gap between two.
  function joined(lists) {
    const out = [];
    lists.forEach((list) => {
      out.push(...flatPairs(list), {x: NaN, y: NaN});
    });
    return out;
  }

  function colorScale(values, logarithmic) {
    const sorted = values.filter((v) => v !== null && (!logarithmic || v > 0)).sort((a, b) => a - b);
    if (sorted.length === 0) return null;
    // The scale ends where 98 of 100 points are, so that one bad point does not grey all others.
    const low = sorted[0];
    const high = sorted[Math.min(sorted.length - 1, Math.floor(0.98 * sorted.length))];
    const to = logarithmic ? Math.log : (v) => v;
    const span = to(high) - to(low);
    const color = (value) => {
      if (value === null || (logarithmic && !(value > 0))) return "#ffffff";
      const part = span > 0 ? Math.min(1, Math.max(0, (to(value) - to(low)) / span)) : 0;
      const at = part * (cividis.length - 1);
      const k = Math.min(cividis.length - 2, Math.floor(at));
      const mix = cividis[k].map((c, i) => Math.round(c + (at - k) * (cividis[k + 1][i] - c)));
      return `rgb(${mix.join(",")})`;
    };
    return {low: low, high: high, most: sorted[sorted.length - 1], color: color};
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
  function viewOf(points, swaths, tracks) {
    const block = extent(points);
    const whole = extent(points.concat(swaths, tracks));
    const size = (b) => Math.max(b.x1 - b.x0, b.y1 - b.y0);
    const box = size(whole) <= 2.2 * size(block) ? whole : extent(points.concat(swaths));
    return size(box) <= 2.2 * size(block) ? box : block;
  }

  // Equal scales on both axes, whatever the shape of the canvas.
  function fit(chart, box) {
    const area = chart.chartArea;
    const width = Math.max(1, area.right - area.left);
    const height = Math.max(1, area.bottom - area.top);
    const perPixel = 1.06 * Math.max((box.x1 - box.x0) / width, (box.y1 - box.y0) / height, 1e-12);
    const x = 0.5 * (box.x0 + box.x1);
    const y = 0.5 * (box.y0 + box.y1);
    const want = {
      x: [x - 0.5 * perPixel * width, x + 0.5 * perPixel * width],
      y: [y - 0.5 * perPixel * height, y + 0.5 * perPixel * height]};
    let changed = false;
    ["x", "y"].forEach((name) => {
      const scale = chart.options.scales[name];
      if (Math.abs((scale.min ?? 1e300) - want[name][0]) > 0.5 * perPixel ||
          Math.abs((scale.max ?? 1e300) - want[name][1]) > 0.5 * perPixel) {
        scale.min = want[name][0];
        scale.max = want[name][1];
        changed = true;
      }
    });
    return changed;
  }

  function drawMap(canvas, spec) {
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
    if (spec.errors.length > 0) {
      sets.push({
        label: "errors of check points", group: "errors of check points", data: joined(spec.errors),
        borderColor: colors.orange, borderWidth: 1.8, pointRadius: 0, pointHitRadius: 0});
    }
    if (spec.ellipses.length > 0) {
      sets.push({
        label: "error ellipses", group: "error ellipses", data: joined(spec.ellipses),
        borderColor: colors.ink, borderWidth: 1, pointRadius: 0, pointHitRadius: 0});
    }
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
    const box = viewOf(points, swaths.flat(), tracks.flat());
    // As high as the block is, within the reach of a screen.
    const width = canvas.parentElement.clientWidth;
    const shape = (box.y1 - box.y0) / Math.max(1e-12, box.x1 - box.x0);
    const height = Math.min(Math.max(shape * (width - 70) + 60, 280), Math.max(380, 0.72 * width));
    canvas.parentElement.style.height = `${Math.round(height)}px`;
    const names = spec.unit;
    const chart = new Chart(canvas, {
      type: "line",
      data: {datasets: sets},
      options: {
        scales: {x: axis({label: names}), y: axis({label: names})},
        elements: {line: {tension: 0}},
        interaction: {mode: "nearest", intersect: true},
        plugins: {tooltip: tooltip, filler: {propagate: false}}},
      plugins: [{
        id: "equal",
        afterLayout: (c) => {
          if (c.fitting) return;
          c.fitting = true;
          if (fit(c, box)) c.update("none");
          c.fitting = false;
        }}]});

    const bar = document.createElement("div");
    bar.className = "scale";
    const select = document.createElement("select");
    select.setAttribute("aria-label", "colour of the points");
    spec.values.forEach((value, i) => select.add(new Option(value.label, i)));
    select.value = spec.shown;
    const name = document.createElement("span");
    const low = document.createElement("span");
    const ramp = document.createElement("i");
    const high = document.createElement("span");
    const stops = cividis.map((c) => `rgb(${c.join(",")})`);
    ramp.style.background = `linear-gradient(to right, ${stops.join(",")})`;
    bar.append(select, name, low, ramp, high);
    canvas.parentElement.before(bar);
    const colour = () => {
      const value = spec.values[Number(select.value)];
      const scale = colorScale(value.of, spec.log);
      name.textContent = spec.values.length > 1 ? "" : value.label;
      if (scale) {
        low.textContent = shown(scale.low);
        high.textContent = shown(scale.high) + (scale.most > scale.high ? ` (largest ${shown(scale.most)})` : "");
        pointSet.pointBackgroundColor = value.of.map(scale.color);
      }
      pointSet.values = value.of;
      pointSet.valueLabel = value.label;
      chart.update("none");
    };
    select.addEventListener("change", colour);
    colour();
    addLegend(chart, canvas, true);
    return points.length;
  }

  const data = JSON.parse(document.getElementById("data").textContent);
  data.charts.forEach((spec) => {
    try {
      const canvas = document.getElementById(spec.id);
      const count = spec.type === "map" ? drawMap(canvas, spec) : drawXy(canvas, spec);
      check.charts.push({id: spec.id, type: spec.type, data: count});
    } catch (error) {
      check.errors.push(`${spec.id}: ${error.message}`);
    }
  });
  note();

  // On paper: everything open, and the charts drawn anew at the width of the sheet.
  const resize = () => Object.values(Chart.instances).forEach((chart) => chart.resize());
  window.addEventListener("beforeprint", () => {
    document.querySelectorAll("details").forEach((d) => { d.open = true; });
    document.documentElement.classList.add("paper");
    resize();
  });
  window.addEventListener("afterprint", () => {
    document.documentElement.classList.remove("paper");
    resize();
  });
})();
