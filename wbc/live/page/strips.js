// The time plots below the scene: status of the last seconds.
"use strict";
(() => {
const {make} = wbc;
const SHOWN = 20;  // s, time span of a plot
let last = null, behind = Infinity;

// `least` is the smallest full-scale value of the plot.
const STRIPS = [
  {label: "DCM error", colour: "#7a3fc4", least: 20, of: (g) => 1000 * g.dcm_error,
    word: (g) => `${(1000 * g.dcm_error).toFixed(1)} mm`, most: true},
  {label: "tick", colour: "#2467d6", least: 200, of: (g) => 1e6 * g.tick_time,
    word: (g) => `${(1e6 * g.tick_time).toFixed(0)} µs`, most: true},
  {label: "pushes survived", colour: "#1f9d7a", least: 1, of: (g) => g.survived,
    grey: (g) => g.pushes, word: (g) => `${g.survived} of ${g.pushes}`},
];
// The last plot shows the selected quantity of the tick, as the server sends it.
const CHOSEN = {least: 0, of: null, most: false,
  word: () => (CHOSEN.value === null ? "unknown" : `${+CHOSEN.value.toPrecision(4)}`)};

function build() {
  const box = make("div", {id: "strips"});
  for (const strip of STRIPS) {
    strip.canvas = make("canvas");
    [strip.text, strip.peak] = [make("span"), make("i")];
    strip.points = [];
    const words = make("p", {}, make("b", {textContent: strip.label}), strip.text, strip.peak);
    box.append(make("div", {}, strip.canvas, words));
  }
  const choice = make("select", {id: "quantity", title: "any quantity of the tick"},
    make("option", {value: "", textContent: "any quantity…"}));
  [CHOSEN.canvas, CHOSEN.text, CHOSEN.peak] = [make("canvas"), make("span"), make("i")];
  [CHOSEN.points, CHOSEN.value] = [[], null];
  box.append(make("div", {}, CHOSEN.canvas, make("p", {}, choice, CHOSEN.text, CHOSEN.peak)));
  choice.addEventListener("pointerdown", () => offer(choice));
  choice.addEventListener("focus", () => offer(choice));
  choice.addEventListener("change", () => follow(choice.value));
  document.body.append(box);
}

async function offer(choice) {
  const labels = await (await fetch("/quantities.json")).json();
  if (labels.length + 1 === choice.options.length) return;
  choice.append(...labels.map((label) => make("option", {value: label, textContent: label})));
}

let series = null;
function follow(label) {
  if (series !== null) series.close();
  [CHOSEN.points, CHOSEN.value] = [[], null];
  series = new WebSocket(`ws://${location.host}/series`);
  series.onopen = () => series.send(label);
  series.onmessage = (event) => {
    const {stamp, value} = JSON.parse(event.data);
    CHOSEN.value = value;
    if (value !== null) CHOSEN.points.push([stamp, value, null]);
    while (CHOSEN.points.length && CHOSEN.points[0][0] < stamp - SHOWN - 1) CHOSEN.points.shift();
  };
}

function add(now) {
  last = now;
  // The server's clock is used: a busy page receives several values at once.
  const stamp = now.stamp;
  behind = Math.min(behind, performance.now() / 1000 - stamp);
  for (const strip of STRIPS) {
    strip.points.push([stamp, strip.of(now), strip.grey ? strip.grey(now) : null]);
    while (strip.points[0][0] < stamp - SHOWN - 1) strip.points.shift();
  }
}

function draw() {
  if (last === null) return;
  const end = performance.now() / 1000 - behind;
  for (const strip of [...STRIPS, CHOSEN]) {
    const canvas = strip.canvas, scale = devicePixelRatio || 1;
    const w = canvas.clientWidth * scale, h = canvas.clientHeight * scale;
    if (canvas.width !== w || canvas.height !== h) Object.assign(canvas, {width: w, height: h});
    const pen = canvas.getContext("2d");
    pen.clearRect(0, 0, w, h);
    let peak = 0, base = 0;
    for (const [, value, grey] of strip.points) {
      peak = Math.max(peak, value, grey ?? 0);
      base = Math.min(base, value);
    }
    const range = Math.max(peak - base, strip.least, 1e-12);
    const line = (k, colour) => {
      pen.beginPath();
      for (const point of strip.points) {
        pen.lineTo(w * (1 - (end - point[0]) / SHOWN), h - 2 * scale - (h - 6 * scale) * (point[k] - base) / range);
      }
      pen.strokeStyle = colour;
      pen.lineWidth = 1.5 * scale;
      pen.stroke();
    };
    if (strip.grey) line(2, "#c3ccd5");
    line(1, strip.colour);
    strip.text.textContent = strip.word(last);
    strip.peak.textContent = strip.most ? `, up to ${peak.toFixed(0)}` : "";
  }
}

wbc.strips = {build, add, draw};
})();
