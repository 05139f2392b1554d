// The 3-D view: surface with deviation colours, path, tool, a marker. Drawn only when it changed.

import {
  AmbientLight,
  BufferAttribute,
  BufferGeometry,
  Color,
  DataTexture,
  DirectionalLight,
  DoubleSide,
  Group,
  HemisphereLight,
  LatheGeometry,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  MeshBasicMaterial,
  MeshStandardMaterial,
  NearestFilter,
  PerspectiveCamera,
  Quaternion,
  Raycaster,
  RGBAFormat,
  Scene,
  SphereGeometry,
  SRGBColorSpace,
  Vector2,
  Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { COLUMNS, PLAIN_COLOUR, REACH, UNCUT_COLOUR, colourOf } from "./colour.js";
import { LINES, ROWS, prepared } from "./geometry.js";
import { GradualPicture } from "./gradual.js";
import { COARSE, MOVING, SURFACE } from "./layers.js";
import { StillPicture } from "./still.js";
import { Triad } from "./triad.js";

const UP = new Vector3(0, 0, 1);

export const TOOL_COLOUR = "#8f9aa6";

/** Row 0: the scale; row 1: uncut; row 2: not measured. */
function lookup() {
  const pixels = new Uint8Array(4 * COLUMNS * ROWS);
  for (let row = 0; row < ROWS; row += 1) {
    for (let column = 0; column < COLUMNS; column += 1) {
      const value = REACH * ((2 * (column + 0.5)) / COLUMNS - 1);
      const colour = [colourOf(value), UNCUT_COLOUR, PLAIN_COLOUR, PLAIN_COLOUR][row];
      pixels.set([...colour, 255], 4 * (row * COLUMNS + column));
    }
  }
  const texture = new DataTexture(pixels, COLUMNS, ROWS, RGBAFormat);
  texture.colorSpace = SRGBColorSpace;
  texture.magFilter = NearestFilter;
  texture.minFilter = NearestFilter;
  texture.needsUpdate = true;
  return texture;
}

function surfaceMesh({ surface }, { places, normals }) {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(surface.positions, 3));
  geometry.setAttribute("uv", new BufferAttribute(places, 2));
  geometry.setAttribute("normal", new BufferAttribute(normals, 3));
  geometry.setIndex(new BufferAttribute(surface.triangles, 1));
  const material = new MeshStandardMaterial({
    map: lookup(),
    side: DoubleSide,
    roughness: 0.75,
    metalness: 0,
    polygonOffset: true,
    polygonOffsetFactor: 1.5,
    polygonOffsetUnits: 1.5,
  });
  const mesh = new Mesh(geometry, material);
  mesh.layers.set(SURFACE);
  mesh.frustumCulled = false;
  return mesh;
}

/** The same surface in few triangles. */
function coarseMesh({ geometry: { attributes }, material }, triangles) {
  const geometry = new BufferGeometry();
  for (const [name, attribute] of Object.entries(attributes)) geometry.setAttribute(name, attribute);
  geometry.setIndex(new BufferAttribute(triangles, 1));
  const mesh = new Mesh(geometry, material);
  mesh.layers.set(COARSE);
  mesh.frustumCulled = false;
  return mesh;
}

function pathMesh(corners) {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(corners, 3));
  const lines = new LineSegments(geometry, new LineBasicMaterial({ transparent: true, opacity: 0.9 }));
  // A sphere around so many points takes time, and they are always in the picture.
  lines.frustumCulled = false;
  return lines;
}

/** Solid of revolution of a tool, open to the sight behind it. */
export function toolMesh(outline) {
  const group = new Group();
  if (outline.length < 2) return group;
  const profile = outline.map(([radius, height]) => new Vector2(Math.max(radius, 0), height));
  const lathe = new LatheGeometry(profile, 72);
  lathe.rotateX(Math.PI / 2);
  const material = new MeshStandardMaterial({
    color: TOOL_COLOUR,
    roughness: 0.35,
    metalness: 0.2,
    transparent: true,
    opacity: 0.42,
    side: DoubleSide,
    depthWrite: false,
  });
  group.add(new Mesh(lathe, material));
  return group;
}

/** What the tool must not touch, in the colour of the still picture. */
function fixtureMesh(fixtures) {
  const group = new Group();
  if (!fixtures) return group;
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(fixtures.positions, 3));
  geometry.setIndex(new BufferAttribute(fixtures.triangles, 1));
  const material = new MeshStandardMaterial({
    color: "#d98e3c",
    flatShading: true,
    roughness: 0.8,
    metalness: 0,
    side: DoubleSide,
  });
  group.add(new Mesh(geometry, material));
  return group;
}

/** Marks an object and all in it as moving while a program plays. */
export const setMoving = (object) => object.traverse((one) => one.layers.set(MOVING));

/** Throws where there is no WebGL. */
export function makeRenderer() {
  const renderer = new WebGLRenderer({ antialias: true, alpha: true, preserveDrawingBuffer: true });
  // To ask for errors of a shader is to wait until it is compiled.
  renderer.debug.checkShaderErrors = false;
  renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
  return renderer;
}

export class View {
  /** Throws where there is no WebGL. Renderer and still picture are dear to make: a page of many results keeps one of each. */
  constructor(host, data, renderer = makeRenderer(), still = new StillPicture(renderer)) {
    this.host = host;
    this.data = data;
    this.renderer = renderer;
    host.append(this.renderer.domElement);
    delete host.dataset.picture;
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(28, 1, 0.1, 1000);
    this.camera.up.copy(UP);
    for (const layer of [MOVING, SURFACE]) this.camera.layers.enable(layer);
    this.still = still;
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.zoomToCursor = true;
    this.controls.addEventListener("change", () => this.drawChanging());
    this.triad = new Triad(host);
    this.addLights();
    // Everything that moves with the workpiece.
    this.part = new Group();
    this.scene.add(this.part);
    const arrays = data.prepared ?? prepared(data);
    this.mesh = surfaceMesh(data, arrays);
    this.part.add(this.mesh);
    this.coarse = arrays.coarse && coarseMesh(this.mesh, arrays.coarse);
    this.gradual = this.coarse && new GradualPicture(this);
    if (this.coarse) this.part.add(this.coarse);
    this.lines = Object.fromEntries(LINES.map(({ key }) => [key, pathMesh(arrays.lines[key])]));
    this.part.add(...Object.values(this.lines));
    this.fixtures = fixtureMesh(data.fixtures);
    this.part.add(this.fixtures);
    this.tool = new Group();
    this.tool.add(...data.tools.map(toolMesh));
    setMoving(this.tool);
    this.part.add(this.tool);
    this.addMarker();
    this.measure(arrays);
    this.theme();
    this.observer = new ResizeObserver(() => this.resize());
    this.observer.observe(host);
    this.resize();
  }

  addLights() {
    this.scene.add(new AmbientLight("#ffffff", 0.9), new HemisphereLight("#ffffff", "#8890a0", 1.4));
    this.lamp = new DirectionalLight("#ffffff", 1.3);
    this.scene.add(this.lamp, this.lamp.target);
    this.scene.traverse((one) => one.layers.enableAll());
  }

  addMarker() {
    const material = new MeshBasicMaterial({
      color: "#ff2bd6",
      depthTest: false,
      // Drawn with the transparent things, after the tool.
      transparent: true,
    });
    this.marker = new Mesh(new SphereGeometry(1, 20, 12), material);
    this.marker.visible = false;
    this.marker.renderOrder = 9;
    this.part.add(this.marker);
  }

  measure({ sphere }) {
    const { low, high, count } = this.data.surface;
    if (count > 0) {
      this.centre = new Vector3().fromArray(low.map((x, k) => 0.5 * (x + high[k])));
      this.radius = 0.5 * Math.hypot(...low.map((x, k) => high[k] - x)) || 1;
    } else {
      this.centre = new Vector3().fromArray(sphere?.centre ?? [0, 0, 0]);
      this.radius = sphere?.radius || 1;
    }
  }

  /** Looks at everything from a direction. */
  fit(direction = [-0.75, -1.15, 0.95]) {
    const distance = (1.08 * this.radius) / Math.sin((0.5 * this.camera.fov * Math.PI) / 180);
    const wide = Math.max(1, 1 / Math.max(this.camera.aspect, 0.2));
    const from = new Vector3().fromArray(direction).normalize().multiplyScalar(distance * wide);
    this.controls.target.copy(this.centre);
    this.camera.position.copy(this.centre).add(from);
    this.camera.near = 0.01 * distance;
    this.camera.far = 20 * distance;
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.draw();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.host;
    const [before] = this.size ?? [];
    if (width === 0 || height === 0 || `${this.size}` === `${[width, height]}`) return;
    this.size = [width, height];
    // To set a size is to wait until everything before is drawn.
    const { x, y } = this.renderer.getSize(new Vector2());
    if (x !== width || y !== height) this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    if (before === undefined) return this.fit();
    // A new size empties the canvas: drawn at once, it does not flicker.
    this.changes = "all";
    this.render();
  }

  theme(isDark = matchMedia("(prefers-color-scheme: dark)").matches) {
    for (const { key, light, dark } of LINES) {
      this.lines[key].material.color = new Color(isDark ? dark : light);
    }
    this.draw();
  }

  show(layer, visible) {
    if (layer === "surface") this.mesh.visible = visible;
    else if (layer === "tool" || layer === "fixtures") this[layer].visible = visible;
    else this.lines[layer].visible = visible;
    this.draw();
  }

  placeTool(pose) {
    if (!pose) return;
    this.tool.position.fromArray(pose.tip);
    const turn = new Quaternion().setFromUnitVectors(UP, new Vector3().fromArray(pose.axis));
    this.tool.quaternion.copy(turn);
    this.tool.children.forEach((tool, at) => {
      tool.visible = at === pose.tool;
    });
    this.drawMoving();
  }

  /** Puts the marker at a point; looks at it if asked. */
  mark(point, { look = false } = {}) {
    this.marker.visible = point !== null;
    if (point !== null) {
      this.marker.position.fromArray(point);
      if (look) {
        const offset = this.camera.position.clone().sub(this.controls.target);
        offset.setLength(Math.min(offset.length(), 1.6 * this.radius));
        this.controls.target.copy(this.marker.getWorldPosition(new Vector3()));
        this.camera.position.copy(this.controls.target).add(offset);
        this.controls.update();
      }
    }
    this.draw();
  }

  /** Vertex of the surface under a point of the screen; null beside it. */
  pick(clientX, clientY) {
    const box = this.renderer.domElement.getBoundingClientRect();
    const spot = new Vector2(
      (2 * (clientX - box.left)) / box.width - 1,
      1 - (2 * (clientY - box.top)) / box.height,
    );
    const ray = new Raycaster();
    ray.layers.enable(SURFACE);
    ray.setFromCamera(spot, this.camera);
    const hit = this.mesh.visible ? ray.intersectObject(this.mesh)[0] : undefined;
    if (!hit) return null;
    const { positions } = this.data.surface;
    const place = this.mesh.worldToLocal(hit.point.clone());
    const away = (vertex) =>
      Math.hypot(...[0, 1, 2].map((k) => positions[3 * vertex + k] - place.getComponent(k)));
    const corners = [hit.face.a, hit.face.b, hit.face.c];
    return corners.reduce((best, corner) => (away(corner) < away(best) ? corner : best));
  }

  /** Draws everything; a surface of many triangles stays as it was until all of them are drawn. */
  draw() {
    if (this.changes !== "all") this.changes = "some";
    this.schedule();
  }

  /** Draws everything with the next frame, more is about to change: a surface of many triangles in few of them. */
  drawChanging() {
    this.changes = "all";
    this.schedule();
  }

  /** Draws what moves with the next frame; all else is as it was. */
  drawMoving() {
    this.changes ??= "moving";
    this.schedule();
  }

  schedule() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.render();
    });
  }

  render() {
    const { changes } = this;
    this.changes = null;
    // A lamp at the shoulder of whoever looks.
    this.lamp.position.copy(this.camera.position);
    this.lamp.position.addScaledVector(UP, 0.6 * this.radius);
    this.lamp.target.position.copy(this.controls.target);
    const distance = this.camera.position.distanceTo(this.marker.getWorldPosition(new Vector3()));
    this.marker.scale.setScalar(0.006 * distance);
    if (this.gradual && (this.gradual.isBusy || !this.gradual.isQuick)) this.renderGradually(changes);
    else this.renderAtOnce(changes);
    this.triad.turn(this.camera);
  }

  renderAtOnce(changes) {
    if (changes === "moving") return this.still.render(this.scene, this.camera);
    this.gradual?.stop();
    this.still.isFresh = false;
    this.renderer.render(this.scene, this.camera);
    this.host.dataset.picture = "whole";
  }

  renderGradually(changes) {
    if (changes === "all" || !this.host.dataset.picture) this.gradual.changing();
    else if (changes === "some") this.gradual.begin();
    else if (this.still.isFresh) this.still.render(this.scene, this.camera);
    // A picture that is on its way shows the tool at its end.
    else if (!this.gradual.isBusy) this.gradual.coarse();
  }
}
