// The scene in meshcat's viewer: floor, lights, camera, the objects that Python describes, and the
// status card. A frame consists of the poses of nodes and a caption, the texts of the card.
"use strict";
const DARK = matchMedia("(prefers-color-scheme: dark)").matches;
const COLOURS = DARK
  ? {background: 0x262c33, floor: 0x333a42, fine: 0x3e464f, coarse: 0x505a65, com: 0xf2f5f8}
  : {background: 0xe8edf2, floor: 0xd3d9df, fine: 0xc6cfd8, coarse: 0xa7b3bf, com: 0x23272f};
const COM_COLOUR = 0x23272f;  // as the server sends it, which would not show on a dark floor
var viewer = new MeshCat.Viewer(document.getElementById("meshcat-pane"));
const THREE = MeshCat.THREE;
const element = (id) => document.getElementById(id);
// Tests read this to wait for a complete scene instead of a fixed time.
var wbc = {frames: 0, ready: false, time: null, lost: ""};

function makeSurroundings(scale) {
  wbc.scale = scale;
  for (const path of [["Lights"], ["Grid"], ["Axes"]]) {
    viewer.scene_tree.find(path).object.visible = false;
  }
  const rgb = [16, 8, 0].map((shift) => ((COLOURS.background >> shift) & 255) / 255);
  viewer.set_property(["Background"], "bottom_color", rgb);
  viewer.set_property(["Background"], "top_color", rgb);
  // The floor fades into the background, so that it has no visible edge.
  viewer.scene.fog = new THREE.Fog(COLOURS.background, 5 * scale, 15 * scale);

  const surroundings = viewer.scene_tree.find(["wbc", "surroundings"]).object;
  const floor = new THREE.Mesh(
    new THREE.PlaneGeometry(60, 60), new THREE.MeshLambertMaterial({color: COLOURS.floor}));
  floor.receiveShadow = true;
  floor.position.z = -0.004;
  surroundings.add(floor);
  const lines = (step, half, colour, z) => {
    const grid = new THREE.GridHelper(2 * half, Math.round(2 * half / step), colour, colour);
    grid.rotateX(Math.PI / 2);
    grid.position.z = z;
    surroundings.add(grid);
  };
  lines(0.25, 8, COLOURS.fine, -0.003);
  lines(1.0, 16, COLOURS.coarse, -0.002);

  surroundings.add(new THREE.HemisphereLight(0xffffff, 0xb4bcc6, 0.64));
  const sun = new THREE.DirectionalLight(0xfff6ea, 0.42);
  sun.position.set(2.2, 1.8, 5.0);
  sun.castShadow = true;
  sun.shadow.mapSize.set(2048, 2048);
  Object.assign(sun.shadow.camera, {left: -3, right: 3, top: 3, bottom: -3, near: 0.5, far: 12});
  sun.shadow.bias = -0.0006;
  sun.shadow.normalBias = 0.02;
  sun.shadow.radius = 3;
  const fill = new THREE.DirectionalLight(0xe6efff, 0.30);
  fill.position.set(-1.5, -3.0, 1.5);
  // The targets of the lights move with the surroundings; by default they stay at the origin.
  surroundings.add(sun, sun.target, fill, fill.target);

  viewer.camera.fov = 32;
  viewer.camera.near = 0.02;
  viewer.camera.far = 60;
  // In the frame of the camera's parent y points up and z to the robot's right.
  const distance = 1.85 * scale;
  viewer.camera.position.set(0.86 * distance, 0.34 * distance, 1.05 * distance);
  // Orbit controls use the frame of the camera's parent, three.js's lookAt uses the world
  // frame: without this conversion a following camera would look at the origin.
  const turn = new THREE.Matrix4();
  viewer.camera.lookAt = function (target) {
    this.quaternion.setFromRotationMatrix(turn.lookAt(this.position, target, this.up));
  };
  viewer.set_dirty();
}

// Completes the scene after its last object.
function finishScene() {
  // Only the robot casts a shadow, not the symbols.
  const root = viewer.scene_tree.find(["wbc"]);
  for (const [name, child] of Object.entries(root.children)) {
    const solid = name === "robot" || name === "terrain";
    if (name === "surroundings") continue;
    child.object.traverse((part) => {
      part.castShadow = name === "robot";
      part.receiveShadow = solid;
      part.frustumCulled = solid;
      if (!solid && part.material?.color?.getHex() === COM_COLOUR) part.material.color.set(COLOURS.com);
    });
  }
  element("wait").remove();
  document.body.classList.add("complete");
  viewer.set_dirty();
}

const nodesAt = (paths) =>
  paths.map((path) => viewer.scene_tree.find(path.split("/").filter((x) => x)).object);

let held = null, latest = null;  // the node that stays where it is, and the pose that it would have

// Lets the node of a path stay where it is, or, for null, catch up with what it has missed.
function holdNode(path) {
  const [object, pose] = [held, latest];
  held = path && nodesAt([path])[0];
  latest = null;
  if (object && pose) setPose(object, pose, 0);
  viewer.set_dirty();
}

// Sets the pose of a node: position, quaternion and scale from 10 numbers of an array.
function setPose(object, numbers, start) {
  if (object === held) {
    latest = Array.from(numbers.slice(start, start + 10));
    return;
  }
  object.position.fromArray(numbers, start);
  object.quaternion.fromArray(numbers, start + 3);
  object.scale.fromArray(numbers, start + 7);
  object.visible = numbers[start + 7] > 0;
}

function showCaption(caption) {
  element("status-light").style.background = caption.colour;
  element("status-light").title = caption.status;
  element("time").textContent = `t = ${caption.time.toFixed(2)} s`;
  element("phase").textContent = caption.phase;
  element("text").textContent = caption.text;
  wbc.time = caption.time;
}
