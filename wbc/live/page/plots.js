// The time plots below the scene: the last seconds of the status and of a selected quantity.
"use strict";
(() => {
const {make} = wbc;
const SPAN = 20;  // s, time span of a plot
// The offset of the browser's clock from the server's, s. The server's stamps are used because a
// busy page receives several values at once.
let offset = Infinity;

// `value` and `reference` return numbers of a status, `text` describes it; `least` is the smallest
// full-scale value.
const PLOTS = [
  {label: "DCM error", colour: "#7a3fc4", least: 20, value: (status) => 1000 * status.dcm_error,
    text: (value) => `${value.toFixed(1)} mm`, peak: true},
  {label: "tick", colour: "#2467d6", least: 200, value: (status) => 1e6 * status.tick_time,
    text: (value) => `${value.toFixed(0)} µs`, peak: true},
  {label: "pushes survived", colour: "#1f9d7a", least: 1, value: (status) => status.survived,
    reference: (status) => status.pushes, text: (value, reference) => `${value} of ${reference}`},
  {label: null, colour: "#23272f", least: 0, value: (status, quantity) => quantity,
    text: (value) => (value === null ? "unknown" : `${+value.toPrecision(4)}`)},
];
const selected = PLOTS[3];
const select = make("select", {id: "quantity", title: "any quantity of the tick"});

function build(onSelect) {
  const box = make("div", {id: "plots"});
  for (const plot of PLOTS) {
    plot.points = [];
    [plot.canvas, plot.caption, plot.range] = [make("canvas"), make("span"), make("i")];
    const title = plot.label ? make("b", {textContent: plot.label}) : select;
    box.append(make("div", {}, plot.canvas, make("p", {}, title, plot.caption, plot.range)));
  }
  offer([]);
  select.addEventListener("change", () => {
    selected.points = [];
    onSelect(select.value);
  });
  document.body.append(box);
}

function offer(labels) {
  const options = labels.map((label) => make("option", {value: label, textContent: label}));
  select.replaceChildren(make("option", {value: "", textContent: "any quantity…"}), ...options);
}

function add(status, [label, quantity] = []) {
  const stamp = status.stamp;
  offset = Math.min(offset, performance.now() / 1000 - stamp);
  for (const plot of PLOTS) {
    // The server may not have received the latest selection yet.
    if (plot === selected && label !== select.value) continue;
    plot.points.push([stamp, plot.value(status, quantity), plot.reference?.(status)]);
    while (plot.points[0][0] < stamp - SPAN - 1) plot.points.shift();
  }
}

function draw() {
  for (const plot of PLOTS) drawPlot(plot, performance.now() / 1000 - offset);
}

function drawPlot({points, canvas, colour, least, reference, ...plot}, end) {
  const scale = devicePixelRatio || 1;
  const width = canvas.clientWidth * scale, height = canvas.clientHeight * scale;
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, {width, height});
  const context = canvas.getContext("2d");
  context.clearRect(0, 0, width, height);
  if (points.length === 0) {
    plot.caption.textContent = "";
    return;
  }
  let high = 0, low = 0;
  for (const [, value, other] of points) {
    high = Math.max(high, value, other ?? 0);
    low = Math.min(low, value);
  }
  const range = Math.max(high - low, least, 1e-12);
  const line = (k, style) => {
    context.beginPath();
    for (const point of points) {
      if (point[k] === null) continue;
      const y = height - 2 * scale - (height - 6 * scale) * (point[k] - low) / range;
      context.lineTo(width * (1 - (end - point[0]) / SPAN), y);
    }
    context.strokeStyle = style;
    context.lineWidth = 1.5 * scale;
    context.stroke();
  };
  if (reference) line(2, "#c3ccd5");
  line(1, colour);
  plot.caption.textContent = plot.text(...points.at(-1).slice(1));
  if (plot.peak) plot.range.textContent = `, up to ${high.toFixed(0)}`;
}

wbc.plots = {build, offer, add, draw};
})();
