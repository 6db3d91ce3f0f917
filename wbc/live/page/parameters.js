// The parameters of a motion: one row each, according to its kind.
"use strict";
(() => {
const {make, session} = wbc;

// Returns a form for a motion's parameters; `changed` returns those that differ from the defaults.
function makeForm(motion, button, play) {
  const fields = motion.parameters.map((parameter) => makeField(motion.name, parameter));
  const form = make("form", {hidden: true}, ...fields.map((field) => field.row),
    make("div", {className: "buttons"}, make("button", {textContent: "Play"}),
      make("button", {type: "reset", textContent: "Reset to defaults"})));
  form.dataset.form = motion.name;
  const changed = () => Object.fromEntries(fields.filter((f) => f.changed()).map((f) => [f.name, f.value()]));
  const mark = () => {
    for (const field of fields) field.row.classList.toggle("changed", field.changed());
    button.classList.toggle("changed", fields.some((field) => field.changed()));
  };
  form.oninput = mark;
  form.onreset = () => setTimeout(mark);
  form.onsubmit = (event) => { event.preventDefault(); play(); };
  return {form, changed};
}

// The server refuses values that are not numbers, with an error message.
const number = (input) => input.value === "" ? null : +input.value;

function makeField(motion, {name, kind, default: initial, about, choices, names, suffixes}) {
  const label = `${motion}.${name}`;
  const box = (type, value, settings = {}) => {
    const input = make("input", {type, defaultValue: value, ...settings});
    input.dataset.parameter = label;
    input.setAttribute("aria-label", label);
    return input;
  };
  const numeric = (value, settings) =>
    box("number", value === null ? "" : +(+value).toPrecision(5), {step: "any", ...settings});
  const inputs = kind === "switch" ? [box("checkbox", "", {defaultChecked: initial})]
    : kind === "vector" ? names.map((axis, i) => numeric(initial?.[i] ?? null, {placeholder: axis}))
    : kind === "choice" ? [make("select", {}, ...choices.map((choice) =>
      make("option", {textContent: choice, defaultSelected: choice === initial})))]
    : kind === "file" ? [session.fileList(suffixes, [initial]), ...session.uploadButton(suffixes.join(), "…", "send a file",
      (answer) => { inputs[0].value = answer.name; inputs[0].dispatchEvent(new Event("input", {bubbles: true})); })]
    : kind === "text" ? [box("text", initial)]
    : [numeric(initial, kind === "whole" ? {step: 1} : {})];
  if (kind === "choice" || kind === "file") inputs[0].dataset.parameter = label;
  const [input] = inputs;
  return {
    name,
    row: make("label", {className: `field ${kind}`}, make("span", {textContent: name.replaceAll("_", " ")}),
      make("span", {className: "inputs"}, ...inputs), make("small", {textContent: about})),
    changed: () => inputs.some((i) => kind === "switch" ? i.checked !== i.defaultChecked
      : kind === "choice" ? i.value !== initial : kind === "file" ? input.value !== initial : i.value !== i.defaultValue),
    value: () => kind === "switch" ? input.checked
      : kind === "vector" ? (inputs.every((i) => i.value === "") ? null : inputs.map(number))
      : ["choice", "file", "text"].includes(kind) ? input.value : number(input),
  };
}

wbc.makeForm = makeForm;
})();
