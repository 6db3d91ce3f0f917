// The control panel, built from the controls that the server describes. A control sends
// {"control": name, "value": …, "source": "page" or "keyboard"}; the server sends values and status
// to every page.
"use strict";
(() => {
const {make, text, slider, makeForm, strips, timeline, camera, pointer, keys, why, session, tasks} = wbc;
const GROUPS = [["robot", "robot"], ["forces", "contact forces"], ["balance", "CoM, DCM, ZMP"],
  ["trail", "CoM trail"], ["support", "support polygon"], ["footsteps", "footsteps"],
  ["swing", "swing path"], ["terrain", "terrain"]];
const sliders = new Map();
const buttons = new Map();
const UNDO_PERIOD = 1000;  // ms within which changes of one parameter count as one
let pushSize = () => 0;
let socket = null, controls = null, status = null, source = "page", errorEnds = 0;
let changes = [];  // name, function and time of each change that can be undone
let group = null;  // the functions of changes that are being made together
// Tests read this.
wbc.live = {status: null, values: {}, errors: [], outcomes: [], saved: ""};

function send(control, value) {
  if (socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify({control, value, source}));
}

function makeSlider(parameter) {
  const move = slider(parameter.low, parameter.high, parameter.logarithmic);
  const output = make("output");
  const range = parameter.low === parameter.high ? "this robot cannot"
    : `${text(parameter.low, parameter.unit)} to ${text(parameter.high, parameter.unit)}; `
      + `double click: ${text(parameter.default, parameter.unit)}`;
  const row = make("label", {className: "slider", title: `${parameter.name}: ${range}`},
    make("span", {textContent: parameter.label}), move.input, output);
  const show = (value) => {
    output.textContent = text(value, parameter.unit);
    row.classList.toggle("changed", Math.abs(value - parameter.default) > 1e-3 * (parameter.high - parameter.low));
    wbc.live.values[parameter.name] = value;
    tasks.receiveWeight(parameter.name, value);
  };
  const change = (value) => {
    const before = wbc.live.values[parameter.name];
    remember(parameter.name, () => sliders.get(parameter.name).change(before));
    show(value);
    send(parameter.name, value);
  };
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
      const off = parameter.switchable && value === 0;
      const clamped = off ? 0 : Math.min(Math.max(value, parameter.low), parameter.high);
      move.set(clamped);
      change(clamped);
    },
  });
  move.set(parameter.default);
  show(parameter.default);
  return row;
}

// Notes how a change is taken back. Changes of one name that follow each other at once, as those of a
// slider that is dragged, are one. Velocities are no parameters: they are commanded anew all the time.
function remember(name, takeBack) {
  if (name?.startsWith("velocity.")) return;
  if (group) {
    group.push(takeBack);
    return;
  }
  const last = changes.at(-1), now = performance.now();
  if (name && last?.name === name && now - last.time < UNDO_PERIOD) last.time = now;
  else changes.push({name, takeBack, time: now});
  changes = changes.slice(-100);
}

// Makes changes that are taken back together.
function together(perform) {
  group = [];
  perform();
  const all = group;
  group = null;
  if (all.length) remember(null, () => { for (const takeBack of all) takeBack(); });
}

function undo() {
  const last = changes.pop();
  if (!last) return;
  group = [];  // the undoing itself is no change
  last.takeBack();
  group = null;
}

const inGroup = (group) => controls.parameters.filter((parameter) => parameter.group === group);
const defaultsButton = (includes) => make("button", {className: "defaults", textContent: "Reset to defaults", onclick: () => {
  const isChanged = ({name, default: initial}) => wbc.live.values[name] !== initial;
  together(() => {
    for (const parameter of controls.parameters.filter(includes).filter(isChanged)) sliders.get(parameter.name).change(parameter.default);
  });
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
    pad.innerHTML = '<circle r="50" style="fill: var(--field); stroke: var(--edge)"/>' +
      '<circle r="33" style="fill: none; stroke: var(--edge)"/><circle r="17" style="fill: none; stroke: var(--edge)"/>' +
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
  pushSize = () => size.get();
  size.input.setAttribute("aria-label", "size of the push");
  size.input.oninput = draw;
  size.set(0.2 * largest);
  draw();
  return section("Push", make("div", {className: "push"}, pad, make("div", {},
    make("label", {className: "slider"}, size.input, output),
    action("push", "Push", "in the direction of the arrow; key: P", push),
    make("small", {id: "pushes"}))));
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
  const names = [...new Set(controls.parameters.map((parameter) => parameter.group))].filter((g) => !others.has(g));
  return folded("Tasks: weights and gains", ...names.flatMap((task) => {
    const rows = inGroup(task).map(makeSlider);
    return [tasks.title(task, sliders.get(`${task}.weight`), wbc.live.values), ...rows];
  }), ...tasks.adder(send, remember),
    defaultsButton((parameter) => !others.has(parameter.group)));
}

// Offers a file of the gains and gait parameters that differ from the defaults, for --gains.
function saveGains() {
  const changed = controls.parameters.filter(({name, group, default: initial}) =>
    !["velocity", "time"].includes(group) && Math.abs(wbc.live.values[name] - initial) > 1e-9 * Math.abs(initial));
  const lines = changed.map(({name, unit}) => `"${name}" = ${+wbc.live.values[name].toPrecision(6)}${unit && `  # ${unit}`}`);
  const text = [`# Gains of ${element("name").textContent}, for  wbc live --gains FILE`, ...lines, ""].join("\n");
  wbc.live.gains = text;
  const address = URL.createObjectURL(new Blob([text], {type: "text/plain"}));
  make("a", {href: address, download: `${element("name").textContent}_gains.toml`}).click();
  setTimeout(() => URL.revokeObjectURL(address), 10000);
}

function changesSection() {
  return make("div", {className: "buttons changes"},
    action("undo", "Undo", "take back the last change of a task, a gain, a gait parameter or the speed; key: Z", undo),
    action("save gains", "Save gains", "the changed gains and gait parameters as a file for --gains", saveGains));
}

function showStatus(now) {
  status = wbc.live.status = now;
  timeline.receiveStatus(now);
  camera.turn(now.heading ?? 0);
  pointer.showHands(now.hands);
  const [title, reason] = {running: ["", ""], paused: ["Paused", ""],
    fallen: ["Robot fell — press Reset (R)", now.fall]}[now.mode];
  const banner = element("banner");
  banner.querySelector("span").textContent = title;
  banner.querySelector("small").textContent = reason;
  document.body.classList.toggle("fallen", now.mode === "fallen");
  buttons.get("pause").textContent = now.mode === "paused" ? "Resume" : "Pause";
  buttons.get("pause").classList.toggle("on", now.mode === "paused");
  buttons.get("reset").classList.toggle("urgent", now.mode === "fallen");
  buttons.get("undo").disabled = changes.length === 0;
  element("pushes").textContent = now.pushes ? `survived ${now.survived} of ${now.pushes}` : "";
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
wbc.showError = showError;

function bindKeys() {
  const step = (name, share) => () => {
    const {parameter, change} = sliders.get(name);
    const next = wbc.live.values[name] + share * parameter.high;
    change(Math.abs(next) < 0.01 * parameter.high ? 0 : next);
  };
  const press = (name) => () => buttons.get(name).click();
  const click = (id) => () => element(id).click();
  const help = keys.help();
  const views = camera.names.map((name, i) => [`${i + 1}`, () => { element("view").value = name; camera.look(name); }]);
  const bound = {
    ArrowUp: step("velocity.forward", 0.1), ArrowDown: step("velocity.forward", -0.1),
    ArrowLeft: step("velocity.turn", 0.15), ArrowRight: step("velocity.turn", -0.15),
    "shift ArrowLeft": step("velocity.left", 0.25), "shift ArrowRight": step("velocity.left", -0.25),
    s: press("stand"), p: press("push"), r: press("reset"), " ": press("pause"), z: undo,
    ",": () => timeline.step(-0.1), ".": () => timeline.step(0.1),
    "<": () => timeline.step(-2), ">": () => timeline.step(2), ";": () => timeline.step(-2), ":": () => timeline.step(2),
    l: () => timeline.review(null), f: click("follow"), c: click("screenshot"),
    v: () => pointer.choose("view"), w: () => pointer.choose("walk"), x: () => pointer.choose("push"), d: () => pointer.choose("pull"), h: () => pointer.choose("hand"),
    "?": () => help.showModal(), ...Object.fromEntries(views),
  };
  element("help-button").onclick = bound["?"];
  keys.bind(bound, (perform) => {
    source = "keyboard";
    perform();
    source = "page";
  });
  const share = (name, value) => {
    const {parameter, change} = sliders.get(name);
    change(value * (value < 0 && parameter.low < 0 ? -parameter.low : parameter.high));
  };
  keys.bindGamepad({
    walk: (forward, left, turn) => {
      share("velocity.forward", forward);
      share("velocity.left", left);
      share("velocity.turn", turn);
    },
    stand: bound.s, pause: bound[" "], reset: bound.r,
  });
}

function build(description) {
  controls = wbc.controls = description;
  const box = make("div", {id: "panel"});
  box.append(walkSection(), motionSection(), pushSection(), timeSection(), showSection(),
    folded("Gait", ...inGroup("gait").map(makeSlider), defaultsButton((parameter) => parameter.group === "gait")),
    gainSection(), changesSection(), why.section(send), ...session.section(send));
  // A clicked control loses the focus, so that the space key always pauses.
  const blur = (event) => {
    const clicked = event.detail && event.target.closest("button, summary, input[type=checkbox]");
    if (clicked) clicked.blur();
  };
  const tools = make("div", {id: "tools"}, pointer.build(send, () => pushSize()), camera.build(),
    make("div", {className: "tools"}, make("button", {id: "help-button", textContent: "?", title: "keys; key: ?"})));
  const dock = make("div", {id: "dock"}, timeline.build(send), strips.build((labels) => send("signals", labels)));
  const tabs = make("div", {id: "tabs"}, ...[["panel", "Controls"], ["dock", "Signals"]].map(([name, textContent]) =>
    make("button", {textContent, onclick: () => {
      document.body.dataset.tab = name;
      for (const tab of element("tabs").children) tab.classList.toggle("on", tab.textContent === textContent);
    }})));
  tabs.firstChild.classList.add("on");
  for (const part of [box, tools, dock, tabs]) part.addEventListener("click", blur);
  document.body.dataset.tab = "panel";
  document.body.append(box, dock, tools, tabs, make("div", {id: "banner"}, make("div", {}, make("span"), make("small"))),
    make("div", {id: "error"}), make("div", {id: "planning"}));
  fitScene();
  new ResizeObserver(fitScene).observe(element("meshcat-pane"));
  // Meshcat then makes its canvas as large as the window; this comes after it.
  for (const event of ["load", "resize"]) addEventListener(event, fitScene);
  requestAnimationFrame(fitScene);
  bindKeys();
  setInterval(() => {
    strips.draw();
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
    if (received.signals) strips.offer(received.signals, received.limits);
    if (received.past) strips.receivePast(received.past);
    if (received.points) strips.receivePoints(received.points);
    if (received.events) timeline.receiveEvents(received.events);
    if (received.saving) timeline.saving(received.saving);
    if ("saved" in received) timeline.saved(received.saved);
    if ("walk_to" in received) pointer.showTarget(received.walk_to);
    for (const [name, value] of Object.entries(received.values ?? {})) sliders.get(name).set(value);
    for (const [name, why] of Object.entries(received.infeasible ?? {})) {
      const button = buttons.get(`motion ${name}`);
      button.classList.add("infeasible");
      button.title = why;
    }
    if (received.status) showStatus(received.status);
    if (received.outcome) wbc.live.outcomes.push(received);
    if (received.why) why.show(received.why);
    if (received.frame_tasks) tasks.receive(received.frame_tasks);
    if (received.files) session.receiveFiles(received.files);
    if (received.starting) wbc.starting = received.starting;
    if (received.error) showError(received.error);
    if ("planning" in received) {
      element("planning").textContent = received.planning ? `Planning: ${received.planning} … (S cancels)` : "";
    }
  };
  socket.onclose = (event) => {
    disconnected(event);
    for (const control of document.querySelectorAll(":is(#panel, #dock, #tools) :is(button, input, select)")) {
      control.disabled = true;
    }
  };
}
open();
})();
