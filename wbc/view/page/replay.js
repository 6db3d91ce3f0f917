// A completed run that a server shows: the page plays it by its own clock and requests each frame.
// It requests the next frame when the last has arrived: a slow page skips frames and does not lag.
"use strict";
const PLOT_HEIGHT = 50;
let wanted = null, waiting = false;

function request(time = wanted) {
  wanted = time;
  if (waiting || wanted === null || socket.readyState !== WebSocket.OPEN) return;
  waiting = true;
  socket.send(JSON.stringify({time: wanted}));
  wanted = null;
}

function start(run) {
  const marks = run.series.map((series) => plot(series, run));
  const show = (time) => {
    for (const mark of marks) mark.style.left = `${100 * (time - run.start) / (run.end - run.start || 1)}%`;
    request(time);
  };
  wbc.player = new Player(run.start, run.end, {show, waiting: () => waiting});
  wbc.player.mark(run.markers);
}

// Adds the plot of a time series; returns the mark of the current time.
function plot(series, run) {
  const span = run.end - run.start || 1;
  const peak = Math.max(...series.values.filter((x) => x !== null), 1e-12);
  let path = "", command = "M";
  series.values.forEach((value, i) => {
    if (value === null) { command = "M"; return; }
    const x = 1000 * (series.time[i] - run.start) / span;
    const y = PLOT_HEIGHT - 2 - (PLOT_HEIGHT - 6) * value / peak;
    path += `${command}${x.toFixed(1)} ${y.toFixed(1)}`;
    command = "L";
  });
  const row = document.createElement("div");
  row.className = "series";
  row.innerHTML = `<svg viewBox="0 0 1000 ${PLOT_HEIGHT}" preserveAspectRatio="none">` +
    `<path d="${path}" fill="none" stroke="#2f6fb0" stroke-width="1.2" ` +
    'vector-effect="non-scaling-stroke"/></svg><i class="mark"></i><span></span>';
  row.querySelector("span").textContent = `${series.label}, up to ${+peak.toPrecision(3)}`;
  row.onpointerdown = row.onpointermove = (event) => {
    if (!event.buttons) return;
    const frame = row.getBoundingClientRect();
    wbc.player.jump(run.start + span * (event.clientX - frame.left) / frame.width);
  };
  let card = document.querySelector(".all-series");
  if (!card) {
    card = Object.assign(document.createElement("div"), {className: "card all-series"});
    document.body.append(card);
  }
  card.append(row);
  return row.querySelector(".mark");
}

const socket = connect(start, () => { waiting = false; request(); });
socket.addEventListener("close", () => { if (wbc.player) wbc.player.playing = false; });
