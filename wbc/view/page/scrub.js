// A completed run: the page plays it by its own clock and requests each frame from the server.
// It requests the next frame when the last has arrived: a slow page skips frames and does not lag.
"use strict";
const STRIP = 50;
let socket = null, objects = [], run = null;
let now = 0, playing = false, speed = 1, wanted = null, waiting = false, before = null;

function connect() {
  socket = new WebSocket(`ws://${location.host}/socket`);
  socket.binaryType = "arraybuffer";
  socket.onmessage = (message) => {
    if (message.data instanceof ArrayBuffer) {
      addBody(new Uint8Array(message.data));
      return;
    }
    const news = JSON.parse(message.data);
    if (news.scale) makeStage(news.scale);
    if (news.paths) begin(news);
    if (news.caption) {
      news.nodes.forEach((node, i) => place(objects[node], news.poses, 10 * i));
      show(news.caption);
      viewer.set_dirty();
      requestAnimationFrame(() => {
        wbc.frames += 1;
        wbc.ready = true;
        waiting = false;
        ask();
      });
    }
  };
  socket.onclose = () => {
    playing = false;
    element("status-light").style.background = "#b8c0c8";
    element("phase").textContent = "the replay has ended";
  };
}

function begin(news) {
  run = news;
  objects = nodesAt(news.paths);
  finishBodies();
  wirePlayer();
  drawStrips();
  playing = true;
  go(run.start);
  requestAnimationFrame(tick);
}

function ask() {
  if (waiting || wanted === null || socket.readyState !== WebSocket.OPEN) return;
  waiting = true;
  socket.send(JSON.stringify({time: wanted}));
  wanted = null;
}

function go(time) {
  now = Math.min(Math.max(time, run.start), run.end);
  wanted = now;
  ask();
  element("seek").value = now;
  element("clock").textContent = `${now.toFixed(2)} / ${run.end.toFixed(2)} s`;
  for (const mark of document.querySelectorAll(".series .mark")) {
    mark.style.left = `${100 * (now - run.start) / Math.max(run.end - run.start, 1e-9)}%`;
  }
}

function tick(stamp) {
  requestAnimationFrame(tick);
  element("play").textContent = playing ? "❚❚" : "▶";
  if (playing && waiting) return;  // playback time continues while waiting for the frame
  const passed = before === null ? 0 : (stamp - before) / 1000;
  before = stamp;
  if (!playing) return;
  if (now >= run.end) playing = false;
  else go(now + speed * Math.min(passed, 0.5));
}

function jump(time) { playing = false; go(time); }

function toggle() {
  if (!playing && now >= run.end) go(run.start);
  playing = !playing;
}

function wirePlayer() {
  const seek = element("seek");
  element("player").hidden = false;
  Object.assign(seek, {min: run.start, max: run.end, step: 0.002});
  seek.oninput = () => jump(+seek.value);
  element("play").onclick = toggle;
  element("speed").onchange = () => { speed = +element("speed").value; };
  const keys = {
    " ": toggle,
    ArrowLeft: (event) => jump(now - (event.shiftKey ? 1 : 0.02)),
    ArrowRight: (event) => jump(now + (event.shiftKey ? 1 : 0.02)),
    Home: () => jump(run.start),
    End: () => jump(run.end),
  };
  addEventListener("keydown", (event) => {
    const act = keys[event.key];
    if (!act) return;
    event.preventDefault();
    act(event);
  });
}

function drawStrips() {
  const box = document.createElement("div");
  box.className = "card all-series";
  for (const series of run.series) {
    const row = document.createElement("div");
    row.className = "series";
    const top = Math.max(...series.values.filter((x) => x !== null), 1e-12);
    const span = Math.max(run.end - run.start, 1e-9);
    let way = "", pen = "M";
    series.values.forEach((value, i) => {
      if (value === null) { pen = "M"; return; }
      const x = 1000 * (series.time[i] - run.start) / span;
      way += `${pen}${x.toFixed(1)} ${(STRIP - 2 - (STRIP - 6) * value / top).toFixed(1)}`;
      pen = "L";
    });
    row.innerHTML = `<svg viewBox="0 0 1000 ${STRIP}" preserveAspectRatio="none">` +
      `<path d="${way}" fill="none" stroke="#2f6fb0" stroke-width="1.2" ` +
      'vector-effect="non-scaling-stroke"/></svg><i class="mark"></i><span></span>';
    row.querySelector("span").textContent = `${series.label}, up to ${+top.toPrecision(3)}`;
    const seekHere = (event) => {
      if (!event.buttons) return;
      const frame = row.getBoundingClientRect();
      jump(run.start + span * (event.clientX - frame.left) / frame.width);
    };
    row.onpointerdown = seekHere;
    row.onpointermove = seekHere;
    box.append(row);
  }
  if (run.series.length) document.body.append(box);
}

connect();
