// What the mouse or a finger does in the scene: turn the view, send the robot to a place on the
// floor, push a link, or pull it with a spring.
"use strict";
(() => {
const {make} = wbc;
const MODES = {
  view: ["View", "drag to turn the view"],
  walk: ["Walk to", "click the floor; drag to choose where the robot faces there"],
  push: ["Push", "click a link: it is pushed away from you, as far as the slider says"],
  pull: ["Pull", "drag a link with a spring force"],
  hand: ["Hands", "drag the ball or an arrow of a hand, standing or walking; double click the ball: let go"],
};
const PULL_PERIOD = 100;  // ms between two signs that the mouse still pulls
const TURNS = 0.15;  // m of dragging from which on it chooses a heading
let send = () => {}, pushSize = () => 0, mode = "view", pressed = null, timer = null;
const buttons = new Map(), handles = new Map();
const AXES = {x: 0xd1342b, y: 0x1f9d7a, z: 0x2467d6};
const LET_GO = 400;  // ms between the two clicks that let go of a hand
let clicked = 0;
const ray = new THREE.Raycaster();

const world = () => viewer.scene_tree.find(["wbc"]).object;

// Aims the ray through a point of the window.
function aim(event) {
  const frame = viewer.renderer.domElement.getBoundingClientRect();
  const x = 2 * (event.clientX - frame.left) / frame.width - 1;
  const y = 1 - 2 * (event.clientY - frame.top) / frame.height;
  viewer.camera.updateMatrixWorld();
  ray.setFromCamera(new THREE.Vector2(x, y), viewer.camera);
}

// Returns the ray in the robot's world: origin and direction.
function worldRay() {
  const origin = world().worldToLocal(ray.ray.origin.clone());
  const ahead = world().worldToLocal(ray.ray.origin.clone().add(ray.ray.direction));
  return [origin, ahead.sub(origin).normalize()];
}

function floorPoint() {
  const [origin, direction] = worldRay();
  if (direction.z > -1e-3) return null;
  return origin.addScaledVector(direction, -origin.z / direction.z);
}

// Returns the link under the ray: the name of its joint, the point in the world and in its axes.
function linkPoint() {
  const links = Object.entries(viewer.scene_tree.find(["wbc", "robot"]).children);
  const [hit] = ray.intersectObjects(links.map(([, node]) => node.object), true);
  if (!hit) return null;
  const within = (object) => { for (let o = hit.object; o; o = o.parent) if (o === object) return true; return false; };
  const [name, node] = links.find(([, one]) => within(one.object));
  const round = (point) => point.toArray().map((x) => +x.toFixed(4));
  return {link: name.replace(/^</, "").replace(/>$/, ""), world: world().worldToLocal(hit.point.clone()),
    local: round(node.object.worldToLocal(hit.point.clone())), shown: hit.point.clone()};
}

// ---- What shows the target ----

const signs = new Map();

function sign(name, make3d) {
  if (!signs.has(name)) {
    const object = make3d();
    object.renderOrder = 5;
    world().add(object);
    signs.set(name, object);
  }
  return signs.get(name);
}

function showTarget(target) {
  const goal = sign("goal", () => {
    const group = new THREE.Group(), colour = new THREE.MeshBasicMaterial({color: 0x2467d6, transparent: true, opacity: 0.75});
    const ring = new THREE.Mesh(new THREE.TorusGeometry(0.16, 0.014, 8, 40), colour);
    const arrow = new THREE.Mesh(new THREE.ConeGeometry(0.05, 0.16, 12), colour);
    arrow.rotation.z = -Math.PI / 2;
    arrow.position.x = 0.27;
    group.add(ring, arrow);
    return group;
  });
  goal.visible = Boolean(target);
  if (target) {
    goal.position.set(target[0], target[1], 0.015);
    goal.rotation.z = target[2] ?? 0;
    goal.children[1].visible = target[2] !== null && target[2] !== undefined;
  }
  viewer.set_dirty();
}

function showSpring(from, to) {
  const line = sign("spring", () => new THREE.Line(new THREE.BufferGeometry(),
    new THREE.LineBasicMaterial({color: 0xd1342b, depthTest: false})));
  line.visible = Boolean(from);
  if (from) line.geometry.setFromPoints([from, to]);
  line.frustumCulled = false;
  viewer.set_dirty();
}

// ---- Hands ----

// A ball at a hand, or at its target, and an arrow along each axis of the world.
function makeHandle(side) {
  const group = new THREE.Group();
  const material = (color) => new THREE.MeshBasicMaterial({color, transparent: true, opacity: 0.8, depthTest: false});
  const part = (geometry, color, axis) => {
    const mesh = new THREE.Mesh(geometry, material(color));
    mesh.userData = {side, axis};
    mesh.renderOrder = 6;
    group.add(mesh);
    return mesh;
  };
  const scale = wbc.scale / 1.6;  // by the size of the robot
  part(new THREE.SphereGeometry(0.032 * scale, 20, 14), 0xf0a202, null);
  for (const [axis, color] of Object.entries(AXES)) {
    const direction = new THREE.Vector3(...["x", "y", "z"].map((one) => +(one === axis)));
    const turn = new THREE.Quaternion().setFromUnitVectors(new THREE.Vector3(0, 1, 0), direction);
    for (const [geometry, at] of [[new THREE.CylinderGeometry(0.006 * scale, 0.006 * scale, 0.1 * scale), 0.07],
      [new THREE.ConeGeometry(0.017 * scale, 0.05 * scale, 12), 0.135]]) {
      const mesh = part(geometry, color, direction);
      mesh.quaternion.copy(turn);
      mesh.position.copy(direction).multiplyScalar(at * scale);
    }
  }
  return group;
}

// Shows the handles where the server says, but the one that is being dragged.
function showHands(hands) {
  for (const [side, {at, leads}] of Object.entries(hands ?? {})) {
    if (!handles.has(side)) {
      if (mode !== "hand") continue;
      handles.set(side, makeHandle(side));
      world().add(handles.get(side));
    }
    const handle = handles.get(side);
    if (handle.visible !== (mode === "hand")) viewer.set_dirty();
    handle.visible = mode === "hand";
    handle.children[0].material.opacity = leads ? 0.95 : 0.55;
    if (pressed?.side !== side) handle.position.fromArray(at);
  }
}

function grabHandle() {
  const [hit] = ray.intersectObjects([...handles.values()].filter((one) => one.visible), true);
  if (!hit) return null;
  if (motionPlays()) {
    wbc.showError("a motion is playing, which leads the hands: press Stand (S) first");
    return null;
  }
  const {side, axis} = hit.object.userData, start = handles.get(side).position.clone();
  const now = performance.now(), twice = !axis && now - clicked < LET_GO;
  clicked = now;
  if (twice) {
    send("hand", {side, target: null});
    return null;
  }
  const grip = world().worldToLocal(hit.point.clone());
  return {side, axis, start, grip, moved: false, distance: grip.distanceTo(worldRay()[0])};
}

// Moves the handle: along its arrow, or at its distance from the camera.
function dragHandle() {
  const [origin, direction] = worldRay(), {axis, grip, start, distance, side} = pressed;
  let moved;
  if (axis) {  // the point of the axis that is nearest to the ray
    const across = grip.clone().sub(origin), b = axis.dot(direction), d = 1 - b * b;
    if (d < 1e-3) return;
    moved = axis.clone().multiplyScalar((b * direction.dot(across) - axis.dot(across)) / d);
  } else moved = origin.addScaledVector(direction, distance).sub(grip);
  pressed.moved = true;
  handles.get(side).position.copy(start).add(moved);
  viewer.set_dirty();
}

const motionPlays = () => (wbc.live.status?.playing ?? -1) !== -1;

// A motion that begins meanwhile takes the hand.
function sendHand() {
  if (pressed.moved && !motionPlays()) send("hand", {side: pressed.side, target: handles.get(pressed.side).position.toArray().map((x) => +x.toFixed(4))});
}

// ---- Gestures ----

function onDown(event) {
  if (mode === "view" || event.button !== 0) return;
  aim(event);
  if (mode === "walk") {
    const point = floorPoint();
    if (point) pressed = {start: point, yaw: null};
  } else if (mode === "hand") {
    pressed = grabHandle();
    if (pressed) timer = setInterval(sendHand, PULL_PERIOD);
  } else {
    const found = linkPoint();
    if (!found) return;
    if (mode === "push") {
      const [, direction] = worldRay(), flat = Math.hypot(direction.x, direction.y) || 1, size = pushSize();
      send("push", {link: found.link, impulse: [size * direction.x / flat, size * direction.y / flat, 0]});
      return;
    }
    const [origin] = worldRay();
    pressed = {...found, distance: found.world.distanceTo(origin), target: found.world.clone()};
    timer = setInterval(pull, PULL_PERIOD);
    pull();
  }
  if (pressed) viewer.renderer.domElement.setPointerCapture(event.pointerId);
}

function onMove(event) {
  if (!pressed) return;
  aim(event);
  if (mode === "walk") {
    const point = floorPoint();
    if (!point) return;
    const [dx, dy] = [point.x - pressed.start.x, point.y - pressed.start.y];
    pressed.yaw = Math.hypot(dx, dy) > TURNS ? Math.atan2(dy, dx) : null;
    showTarget([pressed.start.x, pressed.start.y, pressed.yaw]);
  } else if (mode === "hand") dragHandle();
  else {
    const [origin, direction] = worldRay();
    pressed.target = origin.addScaledVector(direction, pressed.distance);
    showSpring(pressed.world, pressed.target);
  }
}

function pull() {
  const round = (x) => +x.toFixed(4);
  send("pull", {link: pressed.link, point: pressed.local, target: pressed.target.toArray().map(round)});
}

function onUp() {
  if (!pressed) return;
  if (mode === "walk") {
    const target = [pressed.start.x, pressed.start.y, pressed.yaw];
    showTarget(target);
    send("walk_to", target);
  } else if (mode === "hand") {
    clearInterval(timer);
    sendHand();
  } else {
    clearInterval(timer);
    send("pull", null);
    showSpring(null);
  }
  pressed = null;
}

function choose(name) {
  onUp();
  mode = name;
  for (const [one, button] of buttons) button.classList.toggle("on", one === mode);
  if (viewer.controls) viewer.controls.enabled = mode === "view";
  document.body.dataset.pointer = mode;
  showHands(wbc.live?.status?.hands);
}

function build(sender, size) {
  [send, pushSize] = [sender, size];
  const canvas = viewer.renderer.domElement;
  canvas.addEventListener("pointerdown", onDown);
  canvas.addEventListener("pointermove", onMove);
  canvas.addEventListener("pointerup", onUp);
  canvas.addEventListener("pointercancel", onUp);
  const box = make("div", {className: "tools segmented", role: "group"},
    ...Object.entries(MODES).map(([name, [textContent, title]]) => {
      const button = make("button", {textContent, title, onclick: () => choose(name)});
      button.dataset.pointer = name;
      buttons.set(name, button);
      return button;
    }));
  box.setAttribute("aria-label", "what the mouse does");
  choose("view");
  return box;
}

wbc.pointer = {build, choose, showTarget, showHands, handles, linkPoint: (event) => { aim(event); return linkPoint(); }};
})();
