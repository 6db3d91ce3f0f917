// The bar below the scene: back in time while the robot goes on, marks of events, and what is saved
// of a stretch.
"use strict";
(() => {
const {make, strips} = wbc;
const MARKED = {fall: "fall", falling: "fall", reset: "reset", push: "push"};
let send = () => {}, status = null, events = [], time = null, playing = false, last = null, drawn = 0;
const live = make("button", {id: "live", textContent: "Live", title: "back to the present; key: L", onclick: () => review(null)});
const play = make("button", {id: "review-play", textContent: "▶", title: "play from here", onclick: () => {
  if (time === null) review(Math.max(status.session - 10, status.session_start));
  playing = !playing;
}});
const slider = make("input", {id: "review", type: "range", min: 0, max: 1, step: "any", value: 1});
const ticks = make("div", {id: "event-marks"});
const clock = make("output", {id: "review-clock"});
const stretch = make("select", {id: "stretch", title: "what is saved, up to the time shown"},
  ...[["window", "as drawn"], ["30", "last 30 s"], ["120", "last 2 min"], ["600", "last 10 min"], ["all", "all"]]
    .map(([value, textContent]) => make("option", {value, textContent})));
const logButton = make("button", {id: "save-log", textContent: "Save log", title: "the stretch as a log, for wbc plot and wbc replay", onclick: () => save("log")});
const filmButton = make("button", {id: "save-film", textContent: "Save film", title: "the stretch as a page that plays offline", onclick: () => save("film")});

slider.setAttribute("aria-label", "time of the session");
play.setAttribute("aria-label", "play from here");
stretch.setAttribute("aria-label", "stretch to save");
slider.oninput = () => review(+slider.value);

// Shows an earlier time, s, or the present.
function review(wanted) {
  if (!status) return;
  time = wanted === null ? null : Math.min(Math.max(wanted, status.session_start), status.session);
  if (time === null) playing = false;
  if (liveSocket.readyState === WebSocket.OPEN) liveSocket.send(JSON.stringify({time}));
  strips.review(time);
  const [start, end] = strips.window();
  if (time === null) strips.follow();
  else if (time < start || time > end) strips.zoom(time - (end - start) / 2, time + (end - start) / 2);
  wbc.reviewed = time;
  document.body.classList.toggle("reviewing", time !== null);
  show();
}

const step = (seconds) => review((time ?? status.session) + seconds);

function bounds() {
  const end = time ?? status.session;
  if (stretch.value === "all") return [status.session_start, status.session];
  if (stretch.value === "window") return strips.window();
  return [end - +stretch.value, end];
}

function save(as) {
  if (!status) return;
  const [from, to] = bounds();
  send("save", {as, from, to});
}

function saving(kind) {
  for (const button of [logButton, filmButton]) button.disabled = true;
  (kind === "log" ? logButton : filmButton).textContent = "Saving …";
}

function saved(address) {
  for (const button of [logButton, filmButton]) button.disabled = false;
  logButton.textContent = "Save log";
  filmButton.textContent = "Save film";
  if (!address) return;
  wbc.live.saved = address;
  make("a", {href: `/${address}`, download: address.split("/").at(-1)}).click();
}

function show() {
  live.classList.toggle("on", time === null);
  play.textContent = playing ? "❚❚" : "▶";
  if (!status) return;
  const start = status.session_start, span = Math.max(status.session - start, 1e-3);
  Object.assign(slider, {min: start, max: status.session});
  slider.value = time ?? status.session;
  clock.textContent = time === null ? `${status.session.toFixed(1)} s` : `−${(status.session - time).toFixed(1)} s`;
  ticks.replaceChildren(...events.filter((e) => e.kind in MARKED && e.time >= start).slice(-200).map((event) => {
    const mark = make("button", {className: `mark ${MARKED[event.kind]}`,
      title: `${event.kind} at ${event.time.toFixed(2)} s${event.text && `: ${event.text}`}`,
      onclick: () => review(event.time - (event.kind === "reset" ? -0.1 : 1))});
    mark.style.left = `${100 * (event.time - start) / span}%`;
    mark.tabIndex = -1;
    return mark;
  }));
}

function receiveStatus(now) {
  status = now;
  live.disabled = play.disabled = slider.disabled = false;
  if (performance.now() - drawn > 250) { drawn = performance.now(); show(); }
}

function receiveEvents(found) {
  events = [...events, ...found].slice(-1000);
  strips.mark(events);
  show();
}

function advance(stamp) {
  requestAnimationFrame(advance);
  const passed = last === null ? 0 : (stamp - last) / 1000;
  last = stamp;
  if (!playing || time === null) return;
  review(time + Math.min(passed, 0.2));
  if (time >= status.session - 0.02) review(null);
}

function build(sender) {
  send = sender;
  requestAnimationFrame(advance);
  return make("div", {id: "timeline"}, live, play, make("div", {id: "review-track"}, ticks, slider), clock,
    make("span", {className: "group"}, stretch, logButton, filmButton),
    make("span", {className: "group"}, ...strips.layoutControls()));
}

wbc.timeline = {build, review, step, receiveStatus, receiveEvents, saving, saved, events: () => events};
})();
