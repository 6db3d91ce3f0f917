// A recording: objects, the poses of their nodes over time, and captions, all inside the page.
"use strict";
async function unpack(id) {
  const url = "data:application/octet-stream;base64," + element(id).textContent;
  const packed = await (await fetch(url)).blob();
  const stream = packed.stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).arrayBuffer();
}

function addObjects(buffer) {
  const view = new DataView(buffer);
  for (let start = 0; start < buffer.byteLength;) {
    const size = view.getUint32(start, true);
    // A copy, because typed arrays must be aligned to a multiple of their element size.
    viewer.handle_command_bytearray(new Uint8Array(buffer.slice(start + 4, start + 4 + size)));
    start += 4 + size;
  }
}

async function startRecording() {
  const {scale, paths, smooth, times, captions, markers} = JSON.parse(element("recording").textContent);
  makeSurroundings(scale);
  addObjects(await unpack("objects"));
  finishScene();
  const nodes = nodesAt(paths);
  const poses = new Float32Array(await unpack("poses"));  // by node, number and frame
  const first = new Float32Array(10), second = new Float32Array(10);

  function readPose(pose, node, frame) {
    for (let k = 0; k < 10; k++) pose[k] = poses[(10 * node + k) * captions.length + frame];
  }

  function show(time) {
    const frame = lastBefore(times, time + 1e-6), next = Math.min(frame + 1, captions.length - 1);
    const span = times[next] - times[frame];
    // Between two runs the robot does not move from one place to the other.
    const sameRun = captions[next].run === captions[frame].run && captions[next].time >= captions[frame].time;
    const share = span > 0 && sameRun ? Math.max(time - times[frame], 0) / span : 0;
    nodes.forEach((node, i) => {
      readPose(first, i, frame);
      readPose(second, i, next);
      if (smooth[i] && first[7] > 0 && second[7] > 0) interpolate(first, second, share);
      setPose(node, first, 0);
    });
    showCaption(captions[frame]);
    viewer.set_dirty();
    wbc.frames += 1;
  }

  wbc.player = new Player(times[0], times.at(-1), {show, repeats: true});
  wbc.player.mark(markers);
  wbc.ready = true;
}

// Moves a pose by a share of the way to another one.
function interpolate(pose, other, share) {
  for (const k of [0, 1, 2, 7, 8, 9]) pose[k] += share * (other[k] - pose[k]);
  THREE.Quaternion.slerpFlat(pose, 3, pose, 3, other, 3, share);
}

// Returns the index of the last of ascending times at or before a time, in s.
function lastBefore(times, time) {
  let low = 0, high = times.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (times[middle] <= time) low = middle; else high = middle - 1;
  }
  return low;
}

// For videos: hides the player, and looks from an azimuth and elevation, degrees, and distance, m.
wbc.prepareVideo = (camera) => {
  document.body.classList.add("video");
  if (camera) {
    const [azimuth, elevation] = camera.map((angle) => (angle * Math.PI) / 180);
    const across = Math.cos(elevation);
    viewer.camera.position
      .set(across * Math.cos(azimuth), Math.sin(elevation), -across * Math.sin(azimuth))
      .multiplyScalar(camera[2]);
    viewer.controls.update();
  }
  if (rendersInSoftware()) simplifyRendering();
};

// For videos: stops the player, and draws a time at once.
wbc.drawFrame = (time) => {
  wbc.player.jump(time);
  viewer.render();
  viewer.needs_render = false;
};

startRecording().catch((error) => {
  const wait = element("wait");
  if (wait) wait.textContent = `this recording cannot be shown: ${error}`;
  throw error;
});
