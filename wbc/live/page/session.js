// Another session: robot, terrain and random seed; the files that pages send, a robot description
// with what the doctor found, or a motion.
"use strict";
(() => {
const {make} = wbc;
const ROBOT_SUFFIX = ".urdf";
let files = [], sessions = null;
const lists = [];  // what to do when the files have changed

// Sends a file; returns {name, findings}, or {error}.
async function upload(file) {
  try {
    const answer = await fetch(`/upload/${encodeURIComponent(file.name)}`, {method: "POST", body: file});
    return answer.ok ? await answer.json() : {error: `${file.name} was refused (${answer.status})`};
  } catch {
    return {error: `${file.name} could not be sent`};
  }
}

// A button that lets a person choose a file, and sends it.
function uploadButton(accept, label, title, received) {
  const input = make("input", {type: "file", accept, hidden: true});
  input.dataset.upload = accept;
  const button = make("button", {type: "button", className: "upload", textContent: label, title, onclick: () => input.click()});
  input.onchange = async () => {
    const [file] = input.files;
    input.value = "";
    if (!file) return;
    button.disabled = true;
    button.textContent = "Checking …";
    const answer = await upload(file);
    button.disabled = false;
    button.textContent = label;
    if (answer.error) wbc.showError(answer.error);
    else {
      receiveFiles([...new Set([...files, answer.name])]);  // the list of all may come later
      received(answer);
    }
  };
  return [button, input];
}

function receiveFiles(names) {
  files = names;
  for (const update of lists) update();
}

// A list of files with some suffixes; `fill` adds what else it has.
function fileList(suffixes, others = []) {
  const select = make("select");
  const update = () => {
    const chosen = select.value;
    const found = files.filter((name) => suffixes.some((suffix) => name.toLowerCase().endsWith(suffix)));
    select.replaceChildren(...[...new Set([...others, ...found])].map((value) => make("option", {value, textContent: value || "choose a file"})));
    if (chosen) select.value = chosen;
  };
  lists.push(update);
  update();
  return select;
}

const findingLines = ({severity, subject, what, consequence, cure}) =>
  make("p", {className: severity}, make("b", {textContent: `${severity}, ${subject}:`}), ` ${what} → ${consequence}. Cure: ${cure}.`);

function section(send) {
  ({sessions} = wbc.controls);
  if (!sessions) return [];
  const {present} = sessions;
  const robot = fileList([ROBOT_SUFFIX], [...new Set([...sessions.robots, present.robot])]);
  const terrain = make("select", {}, ...sessions.terrains.map((value) => make("option", {value, textContent: value})));
  const seed = make("input", {type: "number", min: 0, step: 1, value: present.seed});
  [robot.value, terrain.value] = [present.robot, present.terrain];
  const findings = make("div", {id: "findings"});
  const start = make("button", {textContent: "Start a new session", title: "ends this session; its files are kept",
    onclick: () => send("start_session", {robot: robot.value, terrain: terrain.value, seed: +seed.value})});
  start.dataset.action = "start session";
  const checked = new Map();  // name -> findings
  const show = () => {
    const found = checked.get(robot.value);
    findings.replaceChildren(...(found ?? []).map(findingLines));
    if (found?.length === 0) findings.replaceChildren(make("p", {textContent: "The doctor found no defects."}));
    start.disabled = Boolean(found?.some(({severity}) => severity === "error"));
  };
  robot.onchange = show;
  const received = ({name, findings: found}) => {
    checked.set(name, found);
    wbc.live.findings = found;
    if (!files.includes(name)) receiveFiles([...files, name]);
    robot.value = name;
    show();
  };
  const field = (label, input, about = "") => {
    input.setAttribute("aria-label", label);
    input.dataset.session = label;
    return make("label", {className: "field"}, make("span", {textContent: label}), make("span", {className: "inputs"}, input),
      ...(about ? [make("small", {textContent: about})] : []));
  };
  return [make("details", {id: "session"}, make("summary", {textContent: "Session"}),
    field("robot", robot), ...uploadButton(`${ROBOT_SUFFIX},.zip`, "Load a URDF …", "a .urdf file, or a .zip of it and its meshes", received),
    findings, field("terrain", terrain), field("seed", seed, "random seed of sensor noise and terrain"), start)];
}

wbc.session = {section, receiveFiles, fileList, uploadButton};
})();
