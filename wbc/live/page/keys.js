// The keyboard and the gamepad, and the table of the keys.
"use strict";
(() => {
const {make} = wbc;
const HELP = [
  ["↑ ↓", "walk forward, backward"], ["← →", "turn"], ["Shift ← →", "walk sideways"],
  ["S", "stand"], ["Space", "pause, resume"], ["R", "reset"], ["P", "push"],
  ["Z, Ctrl Z", "undo the last change of a task or a parameter"],
  [", .", "back, forward in time by 0.1 s (Shift: 2 s)"], ["L", "live: back to the present"],
  ["1 … 6", "camera: start, front, back, left, right, top"], ["F", "camera follows or stays"],
  ["V W X D H", "mouse: view, walk to, push, pull, lead the hands"], ["C", "picture"], ["?", "this table"],
  ["Gamepad", "left stick: walk; right stick: turn; A: stand; Start: pause; Back: reset"],
];
const DEAD_ZONE = 0.15;

// `keys` maps a key, with "shift " before arrows and marks, to what it does.
function bind(keys, onKey) {
  addEventListener("keydown", (event) => {
    const undo = (event.ctrlKey || event.metaKey) && event.key === "z";
    if ((event.ctrlKey || event.altKey || event.metaKey) && !undo) return;
    // A focused control handles its own keys.
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
    onKey(perform);
  });
}

function help() {
  const dialog = make("dialog", {id: "help"}, make("h2", {textContent: "Keys"}),
    make("table", {}, ...HELP.map(([key, what]) => make("tr", {}, make("th", {textContent: key}), make("td", {textContent: what})))),
    make("button", {textContent: "Close", onclick: () => dialog.close()}));
  document.body.append(dialog);
  return dialog;
}

// Asks the first gamepad ten times per second; `walk` takes shares of the largest velocities.
function bindGamepad({walk, stand, pause, reset}) {
  let moved = false, held = new Set();
  const free = (x) => (Math.abs(x ?? 0) < DEAD_ZONE ? 0 : x);
  setInterval(() => {
    const pad = [...(navigator.getGamepads?.() ?? [])].find((one) => one);
    if (!pad) return;
    const [sideways, forward, turn] = pad.axes.slice(0, 3).map(free);
    if (sideways || forward || turn || moved) walk(-forward, -sideways, -turn);
    moved = Boolean(sideways || forward || turn);
    const now = new Set(pad.buttons.flatMap((button, i) => (button.pressed ? [i] : [])));
    for (const [i, act] of [[0, stand], [9, pause], [8, reset]]) if (now.has(i) && !held.has(i)) act();
    held = now;
  }, 100);
}

wbc.keys = {bind, help, bindGamepad};
})();
