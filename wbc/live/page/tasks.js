// The tasks: their gains, a switch for each, and tasks that hold links, which are added and removed.
"use strict";
(() => {
const {make, text, slider} = wbc;
const WEIGHTS = [1, 1000], WEIGHT = 50;  // of an added task
let send = () => {}, remember = () => {};
const list = make("div", {id: "frame-tasks"});

// A switch in the title of a task: off is a weight of 0. `weight` is the slider of its weight.
function title(task, weight, values) {
  const box = make("input", {type: "checkbox", checked: true, title: `${task}: on or off`});
  box.dataset.task = task;
  box.setAttribute("aria-label", `${task} on or off`);
  let last = weight.parameter.default;
  box.onchange = () => {
    if (!box.checked) last = values[weight.parameter.name] || weight.parameter.default;
    weight.change(box.checked ? last : 0);
  };
  return make("h3", {}, make("label", {className: "task"}, box, task));
}

// Follows what any page has set.
function receiveWeight(name, value) {
  const box = document.querySelector(`[data-task="${CSS.escape(name.replace(/\.weight$/, ""))}"]`);
  if (box && name.endsWith(".weight")) box.checked = value > 0;
}

// Adds a task, changes its weight, or removes it with a weight of 0.
function setWeight(frame, kind, weight) {
  const before = wbc.live.frameTasks?.find((task) => task.frame === frame && task.kind === kind)?.weight ?? 0;
  const command = (value) => send("frame_task", {frame, kind, weight: value});
  remember(before && weight ? `task ${frame} ${kind}` : null, () => command(before));
  command(weight);
}

function row({frame, kind, weight}) {
  const move = slider(...WEIGHTS, true), output = make("output", {textContent: text(weight, "")});
  move.set(weight);
  move.input.setAttribute("aria-label", `weight of ${frame} ${kind}`);
  move.input.oninput = () => { output.textContent = text(move.get(), ""); };
  move.input.onchange = () => { setWeight(frame, kind, move.get()); move.input.blur(); };
  return make("div", {className: "frame-task"}, make("span", {textContent: `${frame}, ${kind}`}), move.input, output,
    make("button", {textContent: "×", title: "remove this task", onclick: () => setWeight(frame, kind, 0)}));
}

function receive(tasks) {
  wbc.live.frameTasks = tasks;
  list.replaceChildren(...tasks.map(row));
}

// What adds a task: link, kind, button.
function adder(sender, noteChange) {
  [send, remember] = [sender, noteChange];
  const option = (value) => make("option", {value, textContent: value});
  const frame = make("select", {}, ...wbc.controls.task_frames.map(option));
  const kind = make("select", {}, ...["position", "orientation"].map(option));
  frame.dataset.choose = "frame";
  frame.setAttribute("aria-label", "link to hold");
  kind.setAttribute("aria-label", "what to hold of it");
  const button = make("button", {textContent: "Add", title: "hold this link where it is relative to the robot",
    onclick: () => setWeight(frame.value, kind.value, WEIGHT)});
  button.dataset.action = "add task";
  return [make("h3", {textContent: "Hold a link"}), list, make("div", {className: "adder"}, frame, kind, button)];
}

wbc.tasks = {title, receiveWeight, receive, adder};
})();
