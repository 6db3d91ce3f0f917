// The camera: follows the robot or stays, looks from fixed sides; pictures and films of the scene.
"use strict";
(() => {
const {make} = wbc;
const CAMERA = "/Cameras/default";
// Direction from the robot to the camera in its heading frame: forward, left, up.
const VIEWS = {
  start: ["Start", null],
  front: ["Front", [1, 0, 0.15]],
  back: ["Back", [-1, 0, 0.15]],
  left: ["Left", [0, 1, 0.15]],
  right: ["Right", [0, -1, 0.15]],
  top: ["Top", [-0.01, 0, 1]],
};
const FRAME_RATE = 30;  // Hz, of a film
let first = null, recorder = null, heading = 0;

function look(name) {
  first ??= viewer.camera.position.clone();
  const direction = VIEWS[name][1];
  if (!direction) viewer.camera.position.copy(first);
  else {
    const [forward, left, up] = direction, c = Math.cos(heading), s = Math.sin(heading);
    // In the frame of the camera's parent y points up, and z against the world's y.
    const position = new THREE.Vector3(c * forward - s * left, up, -(s * forward + c * left));
    viewer.camera.position.copy(position.setLength(viewer.camera.position.length()));
  }
  viewer.controls?.update?.();
  viewer.set_dirty();
}

// A camera that stays keeps its place, and a following one keeps its place beside the robot.
function follow(follows) {
  holdNode(follows ? null : CAMERA);
  wbc.follows = follows;
}

function download(address, name) {
  make("a", {href: address, download: name}).click();
}

function fileName(ending) {
  return `${element("name").textContent}_${(wbc.time ?? 0).toFixed(1)}s.${ending}`;
}

function screenshot() {
  wbc.screenshot = viewer.capture_image();
  download(wbc.screenshot, fileName("png"));
}

// Starts to film the scene, or ends it and offers the film.
function record(button) {
  if (recorder) {
    recorder.stop();
    return;
  }
  const canvas = viewer.renderer.domElement, parts = [];
  const type = ["video/mp4", "video/webm;codecs=vp9", "video/webm"].find((one) => MediaRecorder.isTypeSupported(one));
  recorder = new MediaRecorder(canvas.captureStream(FRAME_RATE), {mimeType: type, videoBitsPerSecond: 6e6});
  recorder.ondataavailable = (event) => parts.push(event.data);
  recorder.onstop = () => {
    recorder = null;
    button.textContent = "Record";
    button.classList.remove("on");
    const film = new Blob(parts, {type});
    wbc.film = film.size;
    const address = URL.createObjectURL(film);
    download(address, fileName(type.startsWith("video/mp4") ? "mp4" : "webm"));
    setTimeout(() => URL.revokeObjectURL(address), 60000);
  };
  recorder.start(1000);
  button.textContent = "Stop";
  button.classList.add("on");
}

function build() {
  const views = make("select", {id: "view", title: "camera; keys: 1 to 6"},
    ...Object.entries(VIEWS).map(([value, [textContent]]) => make("option", {value, textContent})));
  views.setAttribute("aria-label", "camera");
  views.onchange = () => { look(views.value); views.blur(); };
  const follows = make("button", {id: "follow", className: "on", textContent: "Follow", title: "the camera follows the robot; key: F",
    onclick: () => {
      follow(!follows.classList.contains("on"));
      follows.classList.toggle("on", wbc.follows);
    }});
  const picture = make("button", {id: "screenshot", textContent: "Picture", title: "save a picture of the scene; key: C", onclick: screenshot});
  const film = make("button", {id: "record", textContent: "Record", title: "record a film of the scene, and save it", onclick: () => record(film)});
  if (!window.MediaRecorder) film.disabled = true;
  return make("div", {className: "tools"}, views, follows, picture, film);
}

wbc.camera = {build, look, names: Object.keys(VIEWS), turn: (angle) => { heading = angle; }};
})();
