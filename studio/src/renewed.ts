// The still picture of the report's view, with a part of it drawn anew: stock changes where the tool is.

import { Box2, Box3, BufferAttribute, BufferGeometry, type Camera, Group, Mesh, type Object3D, type Scene, Vector2, Vector3, type WebGLRenderTarget, type WebGLRenderer } from "three";
import { MOVING, STILL, SURFACE } from "../../viewer/src/layers.js";
import { StillPicture } from "../../viewer/src/still.js";

/** Pixels around a box that are drawn with it: edges are smooth. */
const RIM = 2;

/** Box on the screen around a box in an object, in pixels of the page from the lower left corner of the picture. */
export function boxOnScreen({ min, max }: Box3, object: Object3D, camera: Camera, size: Vector2): Box2 {
  const box = new Box2();
  const corner = new Vector3();
  for (let bits = 0; bits < 8; bits += 1) {
    corner.set(bits & 1 ? max.x : min.x, bits & 2 ? max.y : min.y, bits & 4 ? max.z : min.z);
    corner.applyMatrix4(object.matrixWorld).applyMatrix4(camera.matrixWorldInverse);
    // Behind the eye a corner has no place on the screen.
    if (corner.z >= 0) return box.set(new Vector2(), size.clone());
    corner.applyMatrix4(camera.projectionMatrix);
    box.expandByPoint(new Vector2(0.5 * size.x * (1 + corner.x), 0.5 * size.y * (1 + corner.y)));
  }
  box.min.floor().subScalar(RIM);
  box.max.ceil().addScalar(RIM);
  return box.intersect(new Box2(new Vector2(), size.clone()));
}

/** Hides what is beside a box on the screen; returns what shows it again. */
export function hideBeside(all: Mesh[], box: Box2, camera: Camera, size: Vector2): () => void {
  const hidden = all.filter((one) => one.visible && !boxOnScreen(one.geometry.boundingBox!, one, camera, size).intersectsBox(box));
  for (const one of hidden) one.visible = false;
  return () => hidden.forEach((one) => (one.visible = true));
}

/** Layer of a surface in patches. */
export const PATCHES = 4;

/** Patches along the longest side of a surface. */
const ALONG = 12;

/** A surface of many triangles in patches: a part of the picture needs few of them. */
export class SurfacePatches {
  readonly group = new Group();
  private readonly patches: Mesh[];

  /** Vertices stay those of the surface. */
  constructor(private readonly surface: Mesh) {
    const { index, attributes } = surface.geometry;
    this.patches = patchesOf(index!.array, attributes.position!.array).map(({ triangles, bounds }) => {
      const geometry = new BufferGeometry();
      for (const [name, attribute] of Object.entries(attributes)) geometry.setAttribute(name, attribute as BufferAttribute);
      geometry.setIndex(new BufferAttribute(triangles, 1));
      geometry.boundingBox = bounds;
      const patch = new Mesh(geometry, surface.material);
      patch.layers.set(PATCHES);
      patch.frustumCulled = false;
      return patch;
    });
    this.group.add(...this.patches);
  }

  /** Shows the patches that are seen within a box on the screen, where the surface is shown at all. */
  showWithin(box: Box2, camera: Camera, size: Vector2): void {
    for (const patch of this.patches) patch.visible = this.surface.visible;
    hideBeside(this.patches, box, camera, size);
  }
}

/** Divides triangles by where their first corners are. */
export function patchesOf(triangles: ArrayLike<number>, positions: ArrayLike<number>): { triangles: Uint32Array<ArrayBuffer>; bounds: Box3 }[] {
  const whole = new Box3();
  const corner = new Vector3();
  for (let at = 0; at < triangles.length; at += 1) whole.expandByPoint(corner.fromArray(positions, 3 * triangles[at]!));
  const step = Math.max(...whole.getSize(corner)) / ALONG || 1;
  const place = (vertex: number) => [0, 1, 2].reduce((sum, k) => sum * (ALONG + 1) + Math.floor((positions[3 * vertex + k]! - whole.min.getComponent(k)) / step), 0);
  const lists = new Map<number, number[]>();
  for (let at = 0; at < triangles.length; at += 3) {
    const key = place(triangles[at]!);
    const list = lists.get(key);
    if (list) list.push(at);
    else lists.set(key, [at]);
  }
  return [...lists.values()].map((list) => {
    const patch = new Uint32Array(3 * list.length);
    const bounds = new Box3();
    list.forEach((from, to) => {
      for (let k = 0; k < 3; k += 1) {
        patch[3 * to + k] = triangles[from + k]!;
        bounds.expandByPoint(corner.fromArray(positions, 3 * triangles[from + k]!));
      }
    });
    return { triangles: patch, bounds };
  });
}

export class RenewedPicture extends StillPicture {
  declare renderer: WebGLRenderer;
  declare target: WebGLRenderTarget | null;

  /** Draws what stands still anew within a box of the screen; `surface` is the layer of its surface. */
  renew(scene: Scene, camera: Camera, box: Box2, surface: number): void {
    if (box.isEmpty() || !this.target) return;
    // What moves is taken away first: colours are copied from the screen.
    this.within(this.covered, () => this.putBack());
    this.covered.makeEmpty();
    camera.layers.set(STILL);
    camera.layers.enable(surface);
    this.within(box, () => {
      this.beginDepths(scene);
      this.renderer.render(scene, camera);
      this.endDepths(scene);
      this.renderer.render(scene, camera);
    });
    this.renderer.copyFramebufferToTexture(this.colours!);
    camera.layers.disable(surface);
    for (const seen of [STILL, MOVING, SURFACE]) camera.layers.enable(seen);
  }

  private putBack(): void {
    const { clippingPlanes } = this.renderer;
    this.renderer.clippingPlanes = [];
    this.renderer.render(this.scene, this.camera);
    this.renderer.clippingPlanes = clippingPlanes;
  }

  /** Draws within a box of the screen, and of the kept depths. */
  private within({ min, max }: Box2, draw: () => void): void {
    if (max.x <= min.x || max.y <= min.y) return;
    const { renderer, target } = this;
    const ratio = renderer.getPixelRatio();
    renderer.setScissor(min.x, min.y, max.x - min.x, max.y - min.y);
    renderer.setScissorTest(true);
    target!.scissor.set(min.x, min.y, max.x - min.x, max.y - min.y).multiplyScalar(ratio);
    target!.scissorTest = true;
    draw();
    target!.scissorTest = false;
    renderer.setScissorTest(false);
  }
}
