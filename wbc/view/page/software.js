// For videos without a graphics card: the same picture in two thirds of the processor's time.
"use strict";
function rendersInSoftware() {
  const context = viewer.renderer.getContext();
  const information = context.getExtension("WEBGL_debug_renderer_info");
  const name = information && context.getParameter(information.UNMASKED_RENDERER_WEBGL);
  return /swiftshader|llvmpipe|software/i.test(name || "");
}

function simplifyRendering() {
  simplifyMaterials();
  simplifyShadow();
  smoothEdges();
}

// No highlights, and no shadows on the robot.
function simplifyMaterials() {
  viewer.scene_tree.find(["wbc", "robot"]).object.traverse((part) => {
    part.receiveShadow = false;
    if (!part.isMesh || !part.material.isMeshPhongMaterial) return;
    const {color, map, opacity, side, transparent, vertexColors} = part.material;
    part.material =
      new THREE.MeshLambertMaterial({color, map, opacity, side, transparent, vertexColors});
  });
}

// A shadow with a quarter of the pixels, which are as large as those of the picture.
function simplifyShadow() {
  viewer.renderer.shadowMap.type = THREE.PCFShadowMap;
  viewer.scene.traverse((part) => {
    if (part.material) part.material.needsUpdate = true;
    if (!part.isDirectionalLight || !part.castShadow) return;
    part.shadow.mapSize.set(1024, 1024);
    part.shadow.map?.dispose();
    part.shadow.map = null;
  });
}

// Draws the scene with one sample per pixel, which takes much less time than the four samples of
// the canvas, and then smooths its edges: FXAA (Timothy Lottes, 2009).
function smoothEdges() {
  const {renderer} = viewer, size = renderer.getDrawingBufferSize(new THREE.Vector2());
  const image = new THREE.WebGLRenderTarget(size.x, size.y);
  const pixel = new THREE.Vector2(1 / size.x, 1 / size.y);
  const material = new THREE.ShaderMaterial({
    uniforms: {image: {value: image.texture}, pixel: {value: pixel}},
    vertexShader: COVERING_SHADER,
    fragmentShader: SMOOTHING_SHADER,
    depthTest: false,
  });
  const cover = new THREE.Mesh(new THREE.PlaneGeometry(2, 2), material);
  cover.frustumCulled = false;
  const screen = new THREE.Scene().add(cover), camera = new THREE.Camera();
  const drawScene = viewer.render.bind(viewer);
  viewer.render = () => {
    renderer.setRenderTarget(image);
    drawScene();
    renderer.setRenderTarget(null);
    renderer.render(screen, camera);
  };
}

const COVERING_SHADER = `
  varying vec2 here;
  void main() { here = uv; gl_Position = vec4(position.xy, 0.0, 1.0); }`;

// Where the brightness of the neighbours differs, averages along the edge, which is normal to the
// gradient. A single pixel that is brighter or darker than all around it would flicker: it takes
// their colour.
const SMOOTHING_SHADER = `
  uniform sampler2D image;
  uniform vec2 pixel;
  varying vec2 here;
  const float VISIBLE = 0.012, REACH = 8.0;  // contrast, 1; half of the length along an edge, pixels

  vec3 at(float x, float y) { return texture2D(image, here + vec2(x, y) * pixel).rgb; }
  float brightness(vec3 colour) { return dot(colour, vec3(0.299, 0.587, 0.114)); }
  float least(vec4 x) { return min(min(x.x, x.y), min(x.z, x.w)); }
  float largest(vec4 x) { return max(max(x.x, x.y), max(x.z, x.w)); }

  void main() {
    vec3 centre = at(0.0, 0.0);
    float own = brightness(centre);
    vec4 corners = vec4(brightness(at(-1.0, 1.0)), brightness(at(1.0, 1.0)),
                        brightness(at(-1.0, -1.0)), brightness(at(1.0, -1.0)));
    float low = min(own, least(corners)), high = max(own, largest(corners));
    gl_FragColor = vec4(centre, 1.0);
    if (high - low < VISIBLE) return;

    vec3 up = at(0.0, 1.0), down = at(0.0, -1.0), left = at(-1.0, 0.0), right = at(1.0, 0.0);
    vec4 sides = vec4(brightness(up), brightness(down), brightness(left), brightness(right));
    if (own < min(least(corners), least(sides)) || own > max(largest(corners), largest(sides))) {
      gl_FragColor.rgb = 0.25 * (up + down + left + right);
      return;
    }

    vec2 along = vec2(corners.z + corners.w - corners.x - corners.y,
                      corners.x + corners.z - corners.y - corners.w);
    float steepness = min(abs(along.x), abs(along.y)) + 0.03 * dot(corners, vec4(1.0)) + 0.008;
    along = clamp(along / steepness, -REACH, REACH);
    vec2 inner = along / 6.0, outer = along / 2.0;
    vec3 close = 0.5 * (at(-inner.x, -inner.y) + at(inner.x, inner.y));
    vec3 wide = 0.5 * close + 0.25 * (at(-outer.x, -outer.y) + at(outer.x, outer.y));
    float found = brightness(wide);
    gl_FragColor.rgb = found < low || found > high ? close : wide;  // beyond: it met another edge
  }`;
