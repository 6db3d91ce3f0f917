// Why the tick that is shown is what it is: on request the server solves it again, beside the loop.
"use strict";
(() => {
const {make} = wbc;
const answer = make("div", {id: "why"});

function section(send) {
  const button = make("button", {textContent: "Explain this tick",
    title: "what each task asked for and got, and which limits stand in its way", onclick: () => send("why", wbc.reviewed ?? null)});
  button.dataset.action = "why";
  return make("details", {}, make("summary", {textContent: "Why"}), button, answer);
}

const line = (text, title = "") => make("p", {textContent: text, title});

function taskLines({name, priority, rows}) {
  const level = priority === 0 ? "exact" : `priority ${priority}`;
  const missed = rows.map(([label, asked, got, unit]) => line(`${label}: asked ${asked}, got ${got} ${unit}`));
  return [make("h3", {textContent: name, title: level}), ...(missed.length ? missed : [line("got what it asked for")])];
}

function limitLines({name, side, cost, unit, priority, gains}) {
  if (priority === 0) return [line(`${name} at its ${side}: in the way of no task`)];
  const gained = gains.map(([task, change, taskUnit]) => `${task} ${change} ${taskUnit}`).join(", ");
  return [make("h3", {textContent: `${name} at its ${side}`}),
    line(`one ${unit} more: ${gained || "no task"} closer`, `saves ${cost} of the cost of priority ${priority}`)];
}

function show({time, error, reason, conflict, tasks, limits}) {
  wbc.live.why = {time, error, reason, conflict, tasks, limits};
  answer.replaceChildren(make("small", {textContent: `at ${time.toFixed(3)} s`}), ...(
    error ? [line(error)]
    : reason ? [make("h3", {textContent: "cannot hold together"}), ...(conflict.length ? conflict : [reason]).map((one) => line(one))]
    : [...tasks.flatMap(taskLines), make("h3", {className: "limits", textContent: limits.length ? "Limits in the way" : "No limit is reached"}),
      ...limits.flatMap(limitLines)]));
}

wbc.why = {section, show};
})();
