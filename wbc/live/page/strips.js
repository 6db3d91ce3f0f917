// Strips: any signals of the tick over time, several per strip, with their limits and the marks of
// events. All strips show the same window of time. While the robot waits after a fall, session time
// stands still, and so do the strips.
"use strict";
(() => {
const thousands = new Intl.NumberFormat("en", {notation: "compact", maximumSignificantDigits: 4});
const axisLabel = (x) => (Math.abs(x) < 1e4 ? String(+x.toPrecision(6)) : thousands.format(x));
const longest = (texts) => Math.max(0, ...(texts ?? []).map((one) => one.length));
const {make} = wbc;
const COLOURS = ["#2f7be8", "#e06a10", "#1f9d7a", "#a349c9", "#d1342b", "#8a7a10", "#0e8fae", "#d0478e"];
const MARKS = {fall: "#d1342b", falling: "#d1342b", reset: "#8a949e", push: "#f0a202"};
const LONGEST = 780;  // s that are kept
const STORAGE = "wbc layouts";
// Least size of a strip, px: as many as fit are seen whole, the others after scrolling.
const NARROWEST = 230, LOWEST = 130;
const DIGIT = 7;  // px, at most, of the font of the axes
// Numbers of these units are shown in a smaller one.
const SMALL = {s: ["µs", 1e6], m: ["mm", 1e3]};
const SMALL_NAMES = /^(controller_time|estimator_time|period|dcm_error)\b/;
const PRESETS = {
  "Balance": [["dcm_error, m"], ["controller_time, s"], ["dcm: y, m", "dcm_reference: y, m", "zmp: y, m"]],
  "Timing": [["controller_time, s"], ["estimator_time, s"], ["period, s"]],
  "Motion of the base": [["v: vx, m/s, rad/s", "v: vy, m/s, rad/s"], ["v: wz, m/s, rad/s"], ["com: z, m"]],
  "One strip": [["dcm_error, m"]],
};
let labels = new Set(), limits = {}, select = () => {};
let strips = [], time = [], values = new Map(), marks = [];
let layout = "Balance", span = 20, frozenEnd = null, cursorTime = null, reviewed = null, dirty = true;
const box = make("div", {id: "strips"});

const dark = matchMedia("(prefers-color-scheme: dark)");

function scaleOf(label) {
  const unit = label.split(", ").at(-1);
  return SMALL_NAMES.test(label) && SMALL[unit] || [unit === label ? "" : label.split(", ").slice(1).join(", "), 1];
}

function titleOf(label) {
  const name = label.split(", ")[0].replaceAll("_", " ").replace("dcm", "DCM").replace("zmp", "ZMP").replace("com:", "CoM:");
  return name[0].toUpperCase() + name.slice(1);
}

function format(value, label) {
  if (value === null || value === undefined) return "–";
  const [unit, factor] = scaleOf(label);
  return `${+(value * factor).toPrecision(4)} ${unit}`.trim();
}

function limitText(label) {
  const [low, high] = limits[label] ?? [null, null];
  if (low === null && high === null) return "";
  if (low === null) return ` (budget ${format(high, label)})`;
  return ` (limits ${format(low, label)} to ${format(high, label)})`;
}

// ---- Data ----

function receivePast({time: times, values: found}) {
  time = times;
  values = new Map(Object.entries(found));
  dirty = true;
}

function receivePoints({time: times, values: found}) {
  for (const label of values.keys()) if (!(label in found)) return;  // selected anew: the past comes
  time.push(...times);
  for (const [label, [low, high]] of values) {
    low.push(...found[label][0]);
    high.push(...found[label][1]);
  }
  if (time.at(-1) - time[0] > LONGEST) {
    const gone = after(time[0] + LONGEST / 10);
    time.splice(0, gone);
    for (const [low, high] of values.values()) { low.splice(0, gone); high.splice(0, gone); }
  }
  dirty = true;
}

// Returns the index of the first sample after a time, in s.
function after(t) {
  let low = 0, high = time.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (time[middle] <= t) low = middle + 1; else high = middle;
  }
  return low;
}

function visibleWindow() {
  const end = frozenEnd ?? Math.max(time.at(-1) ?? 0, span / 4);
  return [end - span, end];
}

// The values of a strip within the window: at each time the least and the largest value.
function dataOf(strip) {
  const [start, end] = visibleWindow();
  const first = Math.max(after(start) - 1, 0), last = Math.min(after(end) + 1, time.length);
  const x = [];
  for (let i = first; i < last; i++) x.push(time[i], time[i]);
  const rows = strip.signals.map((label) => {
    const [low, high] = values.get(label) ?? [[], []], factor = scaleOf(label)[1], row = [];
    const scaled = (value) => (value === null || value === undefined ? null : value * factor);
    for (let i = first; i < last; i++) row.push(scaled(low[i]), scaled(high[i]));
    return row;
  });
  return [x, ...rows];
}

// ---- One strip ----

function rangeOf(strip) {
  return (_, low, high) => {
    if (low === null || high === null) return [0, 1];
    for (const label of strip.signals) {
      const factor = scaleOf(label)[1];
      for (const limit of limits[label] ?? []) {
        if (limit === null) continue;
        const y = limit * factor;  // drawn when the values come near
        if (y > 0 && high > 0.4 * y) high = Math.max(high, y);
        if (y < 0 && low < 0.4 * y) low = Math.min(low, y);
      }
    }
    if (low > 0 && low < 0.5 * high) low = 0;
    const margin = 0.08 * (high - low) || Math.abs(high) * 0.1 || 1;
    return [low === 0 ? 0 : low - margin, high + margin];
  };
}

function drawMarks(strip) {
  return (plot) => {
    const {ctx, bbox} = plot, ratio = devicePixelRatio || 1;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    const vertical = (t, colour, width, dash = []) => {
      const x = plot.valToPos(t, "x", true);
      ctx.strokeStyle = colour;
      ctx.lineWidth = width * ratio;
      ctx.setLineDash(dash.map((d) => d * ratio));
      ctx.beginPath();
      ctx.moveTo(x, bbox.top);
      ctx.lineTo(x, bbox.top + bbox.height);
      ctx.stroke();
    };
    for (const mark of marks) vertical(mark.time, MARKS[mark.kind] ?? "#97a1ac88", mark.kind === "fall" ? 2 : 1);
    if (reviewed !== null) vertical(reviewed, dark.matches ? "#ffffff" : "#23272f", 1.5, [4, 3]);
    ctx.setLineDash([5 * ratio, 4 * ratio]);
    strip.signals.forEach((label, k) => {
      for (const limit of limits[label] ?? []) {
        if (limit === null) continue;
        const y = plot.valToPos(limit * scaleOf(label)[1], "y", true);
        ctx.strokeStyle = COLOURS[k % COLOURS.length];
        ctx.lineWidth = 1.2 * ratio;
        ctx.beginPath();
        ctx.moveTo(bbox.left, y);
        ctx.lineTo(bbox.left + bbox.width, y);
        ctx.stroke();
      }
    });
    ctx.restore();
  };
}

function makePlot(strip) {
  strip.plot?.destroy();
  const ink = dark.matches ? "#aab4bf" : "#66717e", grid = dark.matches ? "#ffffff14" : "#00000012";
  const axis = {stroke: ink, grid: {stroke: grid, width: 1}, ticks: {stroke: grid, width: 1, size: 4}, font: "11px system-ui, sans-serif"};
  strip.plot = new uPlot({
    width: Math.max(strip.body.clientWidth, 60), height: Math.max(strip.body.clientHeight, 40),
    legend: {show: false},
    padding: [6, 8, 0, 0],
    scales: {x: {time: false, range: () => visibleWindow()}, y: {range: rangeOf(strip)}},
    axes: [{...axis, size: 22, gap: 2}, {...axis, gap: 3, size: (_, labels) => Math.max(46, 12 + DIGIT * longest(labels)), values: (_, splits) => splits.map(axisLabel)}],
    cursor: {drag: {x: true, y: false, setScale: false}, sync: {key: "strips"}, y: false, points: {size: 5}},
    series: [{}, ...strip.signals.map((label, k) => (
      {label, stroke: COLOURS[k % COLOURS.length], width: 1.3, points: {show: false}}))],
    hooks: {
      draw: [drawMarks(strip)],
      setSelect: [(plot) => {
        if (plot.select.width < 4) return;
        zoom(plot.posToVal(plot.select.left, "x"), plot.posToVal(plot.select.left + plot.select.width, "x"));
        plot.setSelect({left: 0, width: 0, top: 0, height: 0}, false);
      }],
      setCursor: [(plot) => {
        const now = plot.cursor.left >= 0 ? plot.posToVal(plot.cursor.left, "x") : null;
        if (now !== cursorTime) { cursorTime = now; showValues(); }
      }],
    },
  }, dataOf(strip), strip.body);
}

function makeStrip(signals) {
  const strip = {signals: [...signals], head: make("header"), body: make("div", {className: "plot"})};
  strip.root = make("div", {className: "strip"}, strip.head, strip.body);
  strip.body.addEventListener("wheel", (event) => {
    event.preventDefault();
    const [start, end] = visibleWindow(), factor = event.deltaY > 0 ? 1.25 : 0.8;
    const left = strip.plot ? strip.plot.posToVal(event.offsetX, "x") : end;
    if (frozenEnd === null) { span = Math.min(Math.max(span * factor, 0.5), LONGEST); dirty = true; }
    else zoom(left - (left - start) * factor, left + (end - left) * factor);
  }, {passive: false});
  strip.body.ondblclick = follow;
  buildHead(strip);
  return strip;
}

function buildHead(strip) {
  strip.values = [];
  const chips = strip.signals.map((label, k) => {
    const value = make("output");
    strip.values.push(value);
    const remove = make("button", {textContent: "×", title: `remove ${label}`, onclick: () => {
      strip.signals.splice(k, 1);
      rebuild(strip);
    }});
    remove.setAttribute("aria-label", `remove ${label}`);
    const dot = make("i");
    dot.style.background = COLOURS[k % COLOURS.length];
    const chip = make("span", {className: "signal", title: label + limitText(label)}, dot,
      make("b", {textContent: titleOf(label)}), value, remove);
    chip.dataset.signal = label;
    return chip;
  });
  const add = make("button", {className: "add", textContent: "+ signal", title: "add a signal to this strip", onclick: () => choose(strip, add)});
  const close = make("button", {className: "close", textContent: "×", title: "close this strip", onclick: () => {
    strips = strips.filter((one) => one !== strip);
    strip.plot?.destroy();
    strip.root.remove();
    changed();
  }});
  close.setAttribute("aria-label", "close this strip");
  strip.head.replaceChildren(...chips, add, close);
}

// The search for a signal by its name.
function choose(strip, button) {
  const input = make("input", {type: "search", placeholder: "name of a signal", className: "choose"});
  input.setAttribute("list", "signals");
  input.setAttribute("aria-label", "name of a signal");
  const take = () => {
    if (!labels.has(input.value)) return;
    if (!strip.signals.includes(input.value)) strip.signals.push(input.value);
    rebuild(strip);
  };
  input.oninput = take;
  input.onkeydown = (event) => {
    event.stopPropagation();
    if (event.key === "Enter") {  // the first that contains what was typed
      const found = [...labels].find((label) => label.toLowerCase().includes(input.value.toLowerCase()));
      if (found) { input.value = found; take(); }
    }
    if (event.key === "Escape") buildHead(strip);
  };
  input.onblur = () => setTimeout(() => input.isConnected && buildHead(strip), 200);
  button.replaceWith(input);
  input.focus();
}

function rebuild(strip) {
  buildHead(strip);
  makePlot(strip);
  changed();
}

function changed() {
  const wanted = [...new Set(strips.flatMap((strip) => strip.signals))].filter((label) => labels.has(label));
  for (const label of [...values.keys()]) if (!wanted.includes(label)) values.delete(label);
  if (labels.size) select(wanted);
  storeLayouts({...storedLayouts(), "": strips.map((strip) => strip.signals)});
  dirty = true;
}

function showValues() {
  const index = cursorTime === null ? time.length - 1 : Math.max(after(cursorTime) - 1, 0);
  for (const strip of strips) {
    strip.signals.forEach((label, k) => {
      const [low, high] = values.get(label) ?? [[], []];
      const [a, b] = [low[index], high[index]];
      const text = format(b, label);
      strip.values[k].textContent = text + (strip.signals.length === 1 ? limitText(label) : "");
      strip.values[k].title = a === b ? "" : `from ${format(a, label)} to ${text}`;
    });
  }
}

// ---- Layouts ----

function storedLayouts() {
  try { return JSON.parse(localStorage.getItem(STORAGE)) ?? {}; } catch { return {}; }
}

function storeLayouts(layouts) {
  try { localStorage.setItem(STORAGE, JSON.stringify(layouts)); } catch { /* not permitted here */ }
}

function show(signals) {
  for (const strip of strips) strip.plot?.destroy();
  strips = signals.map(makeStrip);
  box.replaceChildren(...strips.map((strip) => strip.root));
  strips.forEach(makePlot);
  changed();
}

function layoutControls() {
  const list = make("select", {id: "layout", title: "layout of the strips"});
  list.setAttribute("aria-label", "layout of the strips");
  const fill = () => {
    const names = [...Object.keys(PRESETS), ...Object.keys(storedLayouts()).filter((name) => name && !(name in PRESETS))];
    list.replaceChildren(make("option", {value: "", textContent: "Layout …"}),
      ...names.map((name) => make("option", {value: name, textContent: name})));
    list.value = names.includes(layout) ? layout : "";
  };
  list.onchange = () => {
    layout = list.value;
    if (layout) show({...PRESETS, ...storedLayouts()}[layout]);
  };
  const save = make("button", {textContent: "Save layout", onclick: () => {
    const name = prompt("Name of the layout");
    if (!name) return;
    layout = name;
    storeLayouts({...storedLayouts(), [name]: strips.map((strip) => strip.signals)});
    fill();
  }});
  const add = make("button", {textContent: "+ strip", title: "add a strip", onclick: () => {
    const strip = makeStrip([]);
    strips.push(strip);
    box.append(strip.root);
    strips.forEach(makePlot);
    choose(strip, strip.head.querySelector(".add"));
  }});
  add.id = "add-strip";
  fill();
  return [list, save, add];
}

// ---- The window of time ----

function zoom(start, end) {
  span = Math.max(end - start, 0.1);
  frozenEnd = end;
  dirty = true;
}

function follow() {
  frozenEnd = null;
  span = Math.min(span, 60);
  dirty = true;
}

function draw() {
  if (!dirty || !box.clientWidth) return;
  dirty = false;
  for (const strip of strips) {
    const width = strip.body.clientWidth, height = strip.body.clientHeight;
    if (!strip.plot || width < 10 || height < 10) continue;
    if (width !== strip.plot.width || height !== strip.plot.height) strip.plot.setSize({width, height});
    strip.plot.setData(dataOf(strip));
  }
  showValues();
}

function build(onSelect) {
  select = onSelect;
  const list = make("datalist", {id: "signals"});
  document.body.append(list);
  show(storedLayouts()[""] ?? PRESETS[layout]);
  dark.addEventListener("change", () => strips.forEach(makePlot));
  new ResizeObserver(() => {
    box.style.setProperty("--columns", Math.max(Math.floor(box.clientWidth / NARROWEST), 1));
    box.style.setProperty("--rows", Math.max(Math.floor(box.clientHeight / LOWEST), 1));
    dirty = true;
  }).observe(box);
  return box;
}

function offer(names, bounds) {
  labels = new Set(names);
  limits = bounds;
  document.getElementById("signals").replaceChildren(...names.map((name) => make("option", {value: name})));
  for (const strip of strips) buildHead(strip);
  changed();
}

wbc.strips = {
  build, offer, draw, follow, zoom, layoutControls, receivePast, receivePoints, format,
  mark: (all) => { marks = all; dirty = true; },
  review: (t) => { reviewed = t; dirty = true; },
  window: visibleWindow,
  samples: () => time.length,
  signals: () => strips.map((strip) => strip.signals),
};
})();
