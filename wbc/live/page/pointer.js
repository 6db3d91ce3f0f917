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
};
const PULL_PERIOD = 100;  // ms between two signs that the mouse still pulls
const TURNS = 0.15;  // m of dragging from which on it chooses a heading
let send = () => {}, pushSize = () => 0, mode = "view", pressed = null, timer = null;
const buttons = new Map();
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

// ---- Gestures ----

function onDown(event) {
  if (mode === "view" || event.button !== 0) return;
  aim(event);
  if (mode === "walk") {
    const point = floorPoint();
    if (point) pressed = {start: point, yaw: null};
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
  } else {
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

wbc.pointer = {build, choose, showTarget, linkPoint: (event) => { aim(event); return linkPoint(); }};
})();
