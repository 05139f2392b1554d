// What stands still while only the tool moves: drawn once, and put back as a picture with its depths.

import {
  AlwaysDepth,
  Box2,
  DepthTexture,
  DoubleSide,
  FramebufferTexture,
  Mesh,
  MeshBasicMaterial,
  NearestFilter,
  NoBlending,
  OrthographicCamera,
  PlaneGeometry,
  RGBAFormat,
  Scene,
  ShaderMaterial,
  UnsignedIntType,
  Vector2,
  Vector3,
  WebGLRenderTarget,
} from "three";
import { MOVING, STILL, SURFACE } from "./layers.js";

/** Pixels around what moves that are drawn anew with it: edges are smooth. */
const RIM = 2;

/** Box around everything that moves and is seen, in pixels of the page from the lower left corner of the picture. */
function boxOnScreen(scene, camera, size) {
  const box = new Box2();
  const corner = new Vector3();
  const add = (object) => {
    if (!object.visible) return;
    object.children.forEach(add);
    if (!object.geometry || !object.layers.isEnabled(MOVING)) return;
    if (!object.geometry.boundingBox) object.geometry.computeBoundingBox();
    const { min, max } = object.geometry.boundingBox;
    for (let bits = 0; bits < 8; bits += 1) {
      corner.set(bits & 1 ? max.x : min.x, bits & 2 ? max.y : min.y, bits & 4 ? max.z : min.z);
      corner.applyMatrix4(object.matrixWorld).applyMatrix4(camera.matrixWorldInverse);
      // Behind the eye a corner has no place on the screen.
      if (corner.z > -camera.near) return void box.set(new Vector2(), size);
      corner.applyMatrix4(camera.projectionMatrix);
      box.expandByPoint(new Vector2(0.5 * size.x * (1 + corner.x), 0.5 * size.y * (1 + corner.y)));
    }
  };
  scene.updateMatrixWorld();
  add(scene);
  if (box.isEmpty()) return box;
  box.min.floor().subScalar(RIM);
  box.max.ceil().addScalar(RIM);
  return box.intersect(new Box2(new Vector2(), size));
}

/** Draws colours and depths that a target keeps; `last` is added to the end of its shader. */
export function sheetMaterial(last = "") {
  return new ShaderMaterial({
    uniforms: { colours: { value: null }, depths: { value: null } },
    vertexShader: "varying vec2 place; void main() { place = uv; gl_Position = vec4(position.xy, 0.0, 1.0); }",
    fragmentShader: `
      uniform sampler2D colours, depths;
      varying vec2 place;
      void main() {
        gl_FragColor = texture2D(colours, place);
        gl_FragDepth = texture2D(depths, place).r;
        ${last}
      }`,
    depthFunc: AlwaysDepth,
    blending: NoBlending,
    toneMapped: false,
  });
}

export class StillPicture {
  constructor(renderer) {
    this.renderer = renderer;
    this.isFresh = false;
    this.size = new Vector2();
    /** Where the picture has to be put back, as something was drawn over it. */
    this.covered = new Box2();
    // Colours come from the screen, where edges are smooth; depths from a target of their own.
    this.depthMaterial = new MeshBasicMaterial({ colorWrite: false, side: DoubleSide });
    this.camera = new OrthographicCamera(-1, 1, 1, -1, 0, 1);
    this.sheet = new Mesh(new PlaneGeometry(2, 2), sheetMaterial());
    this.sheet.frustumCulled = false;
    this.scene = new Scene();
    this.scene.add(this.sheet);
  }

  /** Draws a scene in which nothing has changed since the last time but what moves. */
  render(scene, camera) {
    const { renderer } = this;
    if (!this.isFresh) this.take(scene, camera);
    const now = boxOnScreen(scene, camera, renderer.getSize(new Vector2()));
    const box = this.covered.union(now);
    this.covered = now;
    if (box.isEmpty()) return;
    const [from, extent] = [box.min, box.getSize(new Vector2())];
    renderer.setScissor(from.x, from.y, extent.x, extent.y);
    renderer.setScissorTest(true);
    const planes = renderer.clippingPlanes;
    renderer.clippingPlanes = [];
    renderer.render(this.scene, this.camera);
    renderer.clippingPlanes = planes;
    camera.layers.set(MOVING);
    renderer.autoClear = false;
    renderer.render(scene, camera);
    renderer.autoClear = true;
    renderer.setScissorTest(false);
    for (const seen of [STILL, SURFACE]) camera.layers.enable(seen);
  }

  /** Draws what stands still, and keeps its colours and depths. */
  take(scene, camera) {
    this.prepare();
    camera.layers.set(STILL);
    camera.layers.enable(SURFACE);
    this.beginDepths(scene);
    this.renderer.render(scene, camera);
    this.endDepths(scene);
    this.renderer.render(scene, camera);
    this.renderer.copyFramebufferToTexture(this.colours);
    this.covered.makeEmpty();
    this.isFresh = true;
  }

  /** What is drawn goes to the depths that are kept. */
  beginDepths(scene) {
    this.renderer.setRenderTarget(this.target);
    scene.overrideMaterial = this.depthMaterial;
  }

  /** What is drawn goes to the screen again. */
  endDepths(scene) {
    scene.overrideMaterial = null;
    this.renderer.setRenderTarget(null);
  }

  /** Something may have been drawn over it everywhere. */
  coverAll() {
    this.covered.set(new Vector2(), this.renderer.getSize(new Vector2()));
  }

  /** Makes room for colours and depths of the size of the screen. */
  prepare() {
    const { renderer, size } = this;
    const { uniforms } = this.sheet.material;
    const before = size.clone();
    renderer.getDrawingBufferSize(size);
    if (!this.target || !before.equals(size)) {
      this.free();
      const depths = new DepthTexture(size.x, size.y, UnsignedIntType);
      depths.minFilter = depths.magFilter = NearestFilter;
      this.target = new WebGLRenderTarget(size.x, size.y, { depthTexture: depths });
      this.colours = new FramebufferTexture(size.x, size.y);
      this.colours.format = RGBAFormat;
      uniforms.colours.value = this.colours;
      uniforms.depths.value = depths;
    }
  }

  /** Compiles what it draws with: the first moving picture would wait for it. */
  compile(scene, camera) {
    const target = new WebGLRenderTarget(1, 1);
    this.renderer.setRenderTarget(target);
    this.renderer.compile(new Mesh(this.sheet.geometry, this.depthMaterial), camera, scene);
    this.renderer.setRenderTarget(null);
    target.dispose();
    this.renderer.compile(this.scene, this.camera);
  }

  free() {
    this.target?.depthTexture?.dispose();
    this.target?.dispose();
    this.colours?.dispose();
    this.target = this.colours = null;
    this.isFresh = false;
  }

  dispose() {
    this.free();
    this.depthMaterial.dispose();
    this.sheet.geometry.dispose();
    this.sheet.material.dispose();
  }
}
