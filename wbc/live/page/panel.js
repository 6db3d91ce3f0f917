// The control panel, built from the controls that the server describes. A control sends
// {"control": name, "value": …, "source": "page" or "keyboard"}; the server sends values and status
// to every page.
"use strict";
(() => {
const {make, text, slider, makeForm, plots} = wbc;
const GROUPS = [["robot", "robot"], ["forces", "contact forces"], ["balance", "CoM, DCM, ZMP"],
  ["trail", "CoM trail"], ["support", "support polygon"], ["footsteps", "footsteps"],
  ["swing", "swing path"], ["terrain", "terrain"]];
const sliders = new Map();
const buttons = new Map();
let socket = null, controls = null, status = null, source = "page", errorEnds = 0;
// Tests read this.
wbc.live = {status: null, values: {}, errors: [], outcomes: []};

function send(control, value) {
  if (socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify({control, value, source}));
}

function makeSlider(parameter) {
  const move = slider(parameter.low, parameter.high, parameter.logarithmic);
  const output = make("output");
  const row = make("label", {className: "slider", title: `${parameter.name}: ${text(parameter.low, parameter.unit)} `
    + `to ${text(parameter.high, parameter.unit)}; double click: ${text(parameter.default, parameter.unit)}`},
    make("span", {textContent: parameter.label}), move.input, output);
  const show = (value) => {
    output.textContent = text(value, parameter.unit);
    row.classList.toggle("changed", Math.abs(value - parameter.default) > 1e-3 * (parameter.high - parameter.low));
    wbc.live.values[parameter.name] = value;
  };
  const change = (value) => { show(value); send(parameter.name, value); };
  move.input.setAttribute("aria-label", parameter.name);
  move.input.dataset.control = parameter.name;
  move.input.oninput = () => {
    const value = move.get();
    // A slider with negative values snaps to zero near its middle.
    change(parameter.low < 0 && Math.abs(value) < 0.03 * parameter.high ? 0 : value);
  };
  move.input.onchange = () => { move.set(wbc.live.values[parameter.name]); move.input.blur(); };
  row.ondblclick = () => { move.set(parameter.default); change(parameter.default); };
  sliders.set(parameter.name, {
    parameter,
    set: (value) => { if (document.activeElement !== move.input) move.set(value); show(value); },
    change: (value) => {
      const clamped = Math.min(Math.max(value, parameter.low), parameter.high);
      move.set(clamped);
      change(clamped);
    },
  });
  move.set(parameter.default);
  show(parameter.default);
  return row;
}

const inGroup = (group) => controls.parameters.filter((parameter) => parameter.group === group);
const defaultsButton = (includes) => make("button", {className: "defaults", textContent: "Reset to defaults", onclick: () => {
  for (const parameter of controls.parameters.filter(includes)) sliders.get(parameter.name).change(parameter.default);
}});

function section(title, ...content) {
  return make("section", {}, make("h2", {textContent: title}), ...content);
}

function folded(title, ...content) {
  return make("details", {}, make("summary", {textContent: title}), ...content);
}

function action(name, label, title, perform) {
  const button = make("button", {textContent: label, title, onclick: perform});
  button.dataset.action = name;
  buttons.set(name, button);
  return button;
}

function walkSection() {
  return section("Walk", ...inGroup("velocity").map(makeSlider),
    make("small", {textContent: "↑ ↓ forward, backward · ← → turn · shift ← → sideways · S stand" }));
}

function walk() {
  const {parameter, change} = sliders.get("velocity.forward");
  change(0.4 * parameter.high);
}

function motionSection() {
  const box = make("div", {className: "buttons"},
    action("stand", "Stand", "stop walking, end the motion and stand; key: S", () => send("stand")),
    action("walk", "Walk", "forward, at 40 % of the largest velocity", walk),
    ...controls.motions.flatMap(makeMotion));
  return section("Motions", box);
}

// The button of a motion, and the form of its parameters, which opens below.
function makeMotion(motion) {
  let changedParameters = () => ({});
  const play = () => {
    const parameters = changedParameters();
    send("motion", Object.keys(parameters).length ? {name: motion.name, parameters} : motion.name);
  };
  const button = action(`motion ${motion.name}`, motion.name, motion.summary, play);
  if (!motion.parameters.length) return [button];
  const {form, changed} = makeForm(motion, button, play);
  changedParameters = changed;
  const more = make("button", {className: "more", textContent: "⋯",
    title: `${motion.name}: ${motion.parameters.map((p) => p.name.replaceAll("_", " ")).join(", ")}`});
  more.dataset.more = motion.name;
  more.setAttribute("aria-expanded", "false");
  more.onclick = () => {
    const opens = form.hidden;
    for (const other of document.querySelectorAll("#panel form")) other.hidden = true;
    for (const other of document.querySelectorAll(".more")) other.setAttribute("aria-expanded", "false");
    form.hidden = !opens;
    more.setAttribute("aria-expanded", String(opens));
  };
  return [make("div", {className: "motion"}, button, more), form];
}

function pushSection() {
  const largest = controls.max_impulse;
  const size = slider(largest / 50, largest, false);
  const output = make("output");
  let angle = Math.PI / 2;
  const pad = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  pad.id = "pad";
  pad.setAttribute("viewBox", "-52 -52 104 104");
  const draw = () => {
    output.textContent = text(size.get(), "N·s");
    // Up is forward; left is the robot's left.
    const reach = 16 + 28 * size.get() / largest;
    const x = -Math.sin(angle), y = -Math.cos(angle);
    const at = (r, side) => `${(r * x - side * y).toFixed(1)} ${(r * y + side * x).toFixed(1)}`;
    pad.innerHTML = '<circle r="50" fill="#fff" stroke="#c9d1d9"/>' +
      '<circle r="33" fill="none" stroke="#eceff2"/><circle r="17" fill="none" stroke="#eceff2"/>' +
      '<ellipse cx="-7" rx="4" ry="9" fill="#c3ccd5"/><ellipse cx="7" rx="4" ry="9" fill="#c3ccd5"/>' +
      '<text y="-37" text-anchor="middle" font-size="9" fill="#8a949e">front</text>' +
      `<path d="M0 0L${at(reach - 8, 0)}" stroke="#d1342b" stroke-width="4" stroke-linecap="round"/>` +
      `<path d="M${at(reach, 0)}L${at(reach - 10, 7)}L${at(reach - 10, -7)}Z" fill="#d1342b"/>`;
  };
  const push = () => {
    send("push", [size.get() * Math.cos(angle), size.get() * Math.sin(angle)]);
  };
  const aim = (event) => {
    if (!event.buttons) return;
    const frame = pad.getBoundingClientRect();
    const x = event.clientX - frame.left - frame.width / 2;
    const y = event.clientY - frame.top - frame.height / 2;
    angle = Math.atan2(-x, -y);
    draw();
  };
  pad.onpointerdown = aim;
  pad.onpointermove = aim;
  size.input.setAttribute("aria-label", "size of the push");
  size.input.oninput = draw;
  size.set(0.2 * largest);
  draw();
  return section("Push", make("div", {className: "push"}, pad, make("div", {},
    make("label", {className: "slider"}, size.input, output),
    action("push", "Push", "in the direction of the arrow; key: P", push))));
}

function timeSection() {
  return section("Time",
    make("div", {className: "buttons"},
      action("pause", "Pause", "key: space", () => send("pause", status?.mode !== "paused")),
      action("reset", "Reset", "return the robot to its initial standing posture; key: R", () => send("reset"))),
    ...inGroup("time").map(makeSlider));
}

function showSection() {
  return folded("Show", ...GROUPS.map(([name, label]) => {
    const box = make("input", {type: "checkbox", checked: true});
    box.dataset.shown = name;
    box.onchange = () => {
      viewer.scene_tree.find(["wbc", name]).object.visible = box.checked;
      viewer.set_dirty();
    };
    return make("label", {className: "toggle"}, box, label);
  }));
}

function gainSection() {
  const others = new Set(["velocity", "time", "gait"]);
  const tasks = [...new Set(controls.parameters.map((parameter) => parameter.group))].filter((g) => !others.has(g));
  return folded("Tasks: weights and gains", ...tasks.flatMap((task) =>
    [make("h3", {textContent: task}), ...inGroup(task).map(makeSlider)]),
    defaultsButton((parameter) => !others.has(parameter.group)));
}

function showStatus(now, quantity) {
  status = wbc.live.status = now;
  plots.add(now, quantity);
  element("banner").firstChild.textContent = {running: "", paused: "Paused",
    fallen: "Robot fell — press Reset (R)"}[now.mode];
  buttons.get("pause").textContent = now.mode === "paused" ? "Resume" : "Pause";
  buttons.get("pause").classList.toggle("on", now.mode === "paused");
  controls.motions.forEach((motion, i) =>
    buttons.get(`motion ${motion.name}`).classList.toggle("on", now.playing === i));
  const walking = now.velocity.some((x) => x !== 0);
  buttons.get("walk").classList.toggle("on", walking);
  buttons.get("stand").classList.toggle("on", !walking && now.playing === -1);
}

function showError(text) {
  wbc.live.errors.push(text);
  element("error").textContent = text;
  errorEnds = performance.now() + 6000;
}

function bindKeys() {
  const step = (name, share) => () => {
    const {parameter, change} = sliders.get(name);
    const next = wbc.live.values[name] + share * parameter.high;
    change(Math.abs(next) < 0.01 * parameter.high ? 0 : next);
  };
  const press = (name) => () => buttons.get(name).click();
  const keys = {
    ArrowUp: step("velocity.forward", 0.1), ArrowDown: step("velocity.forward", -0.1),
    ArrowLeft: step("velocity.turn", 0.15), ArrowRight: step("velocity.turn", -0.15),
    "shift ArrowLeft": step("velocity.left", 0.25), "shift ArrowRight": step("velocity.left", -0.25),
    s: press("stand"), p: press("push"), r: press("reset"), " ": press("pause"),
  };
  addEventListener("keydown", (event) => {
    // A focused control handles its own keys.
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    if (event.target.matches("input:not([type=range], [type=checkbox]), select")) {
      if (event.key === "Escape") event.target.blur();
      return;
    }
    if (event.target.matches("input[type=range]") && event.key.startsWith("Arrow")) return;
    if (event.target.matches("button, summary, input") && event.key === " ") return;
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    const perform = keys[(event.shiftKey && key.startsWith("Arrow") ? "shift " : "") + key];
    if (!perform) return;
    event.preventDefault();
    source = "keyboard";
    perform();
    source = "page";
  });
}

function build(description) {
  controls = description;
  const box = make("div", {id: "panel"});
  box.append(walkSection(), motionSection(), pushSection(), timeSection(), showSection(),
    folded("Gait", ...inGroup("gait").map(makeSlider), defaultsButton((parameter) => parameter.group === "gait")),
    gainSection());
  // A clicked control loses the focus, so that the space key always pauses.
  box.addEventListener("click", (event) => {
    const clicked = event.detail && event.target.closest("button, summary, input[type=checkbox]");
    if (clicked) clicked.blur();
  });
  document.body.append(box, make("div", {id: "banner"}, make("span")), make("div", {id: "error"}),
    make("div", {id: "planning"}));
  plots.build((label) => send("quantity", label));
  fitScene();
  addEventListener("resize", fitScene);
  bindKeys();
  setInterval(() => {
    plots.draw();
    if (performance.now() > errorEnds) element("error").textContent = "";
  }, 50);
}

// By default meshcat's canvas is as high as the window.
function fitScene() {
  const pane = element("meshcat-pane");
  viewer.set_3d_pane_size(pane.clientWidth, pane.clientHeight);
}

function open() {
  const alive = new Worker("alive.js");
  socket = new WebSocket(`ws://${location.host}/controls`);
  socket.onmessage = (message) => {
    const received = JSON.parse(message.data);
    alive.postMessage(received.page);
    if (received.controls) build(received.controls);
    if (received.quantities) plots.offer(received.quantities);
    for (const [name, value] of Object.entries(received.values ?? {})) sliders.get(name).set(value);
    for (const [name, why] of Object.entries(received.infeasible ?? {})) {
      const button = buttons.get(`motion ${name}`);
      button.classList.add("infeasible");
      button.title = why;
    }
    if (received.status) showStatus(received.status, received.quantity);
    if (received.outcome) wbc.live.outcomes.push(received);
    if (received.error) showError(received.error);
    if ("planning" in received) {
      element("planning").textContent = received.planning ? `Planning: ${received.planning} …` : "";
    }
  };
  socket.onclose = (event) => {
    disconnected(event);
    for (const control of document.querySelectorAll("#panel :is(button, input, select)")) {
      control.disabled = true;
    }
  };
}
open();
})();
