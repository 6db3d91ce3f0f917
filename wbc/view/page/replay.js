// A recording: objects, an animation for meshcat's player, and the captions over time.
"use strict";
async function unpack(text) {
  const packed = await (await fetch("data:application/octet-stream;base64," + text)).blob();
  const plain = packed.stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(plain).arrayBuffer());
}

function* messages(bytes) {
  const view = new DataView(bytes.buffer);
  for (let at = 0; at < bytes.length;) {
    const size = view.getUint32(at, true);
    // A copy, because typed arrays must be aligned to a multiple of their element size.
    yield bytes.slice(at + 4, at + 4 + size);
    at += 4 + size;
  }
}

async function replay() {
  const story = JSON.parse(element("story").textContent);
  makeStage(story.scale);
  const all = [...messages(await unpack(element("scene").textContent))];
  const animation = all.pop();
  all.forEach(addBody);
  finishBodies();
  nodesAt(story.paths).forEach((object, i) => place(object, story.first, 10 * i));
  nodesAt(story.paths).forEach((object) => { object.visible = true; });
  viewer.handle_command_bytearray(animation);
  wirePlayer(viewer.animator, story);
  wbc.ready = true;
}

function wirePlayer(animator, story) {
  const [play, seek, clock, speed] = ["play", "seek", "clock", "speed"].map(element);
  const start = story.caption[0].time;
  const toggle = () => (animator.playing ? animator.pause() : animator.play());
  play.onclick = toggle;
  seek.max = animator.duration;
  seek.oninput = () => { animator.pause(); animator.seek(+seek.value); animator.time = +seek.value; };
  speed.onchange = () => { animator.mixer.timeScale = +speed.value; };
  addEventListener("keydown", (event) => {
    if (event.key === " ") { event.preventDefault(); toggle(); }
  });
  element("player").hidden = story.caption.length < 2;
  // For videos: hides the player and shows frames by time.
  wbc.videoMode = () => {
    document.body.classList.add("video");
    animator.pause();
    return story.caption.at(-1).time - start;
  };
  wbc.seek = (time) => {
    animator.seek(time);
    animator.time = time;
    show(story.caption[lastBefore(story.caption, start + time + 1e-6)]);
    viewer.render();
    viewer.needs_render = false;
  };
  let shown = -1;
  const tick = () => {
    requestAnimationFrame(tick);
    const index = lastBefore(story.caption, start + animator.time + 1e-6);
    play.textContent = animator.playing ? "❚❚" : "▶";
    seek.value = animator.time;
    clock.textContent = `${animator.time.toFixed(1)} / ${animator.duration.toFixed(1)} s`;
    if (index === shown) return;
    shown = index;
    wbc.frames += 1;
    show(story.caption[index]);
  };
  tick();
}

function lastBefore(caption, time) {
  let low = 0, high = caption.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (caption[middle].time <= time) low = middle; else high = middle - 1;
  }
  return low;
}

replay().catch((error) => {
  const wait = element("wait");
  if (wait) wait.textContent = `this recording cannot be shown: ${error}`;
  throw error;
});
