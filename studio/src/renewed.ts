// The still picture of the report's view, with a part of it drawn anew: stock changes where the tool is.

import {
  Box2,
  Box3,
  BufferAttribute,
  BufferGeometry,
  type Camera,
  DepthTexture,
  Group,
  Mesh,
  NearestFilter,
  type Object3D,
  SRGBColorSpace,
  Scene,
  type ShaderMaterial,
  UnsignedIntType,
  Vector2,
  Vector3,
  WebGLRenderTarget,
  type WebGLRenderer,
} from "three";
import { MOVING, STILL, SURFACE } from "../../viewer/src/layers.js";
import { StillPicture, sheetMaterial } from "../../viewer/src/still.js";

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

/** Boxes on the screen of things that stand still. */
export class ScreenBoxes {
  private known = new WeakMap<Mesh, Box2>();

  /** Forgets all of them: the view has changed. */
  clear(): void {
    this.known = new WeakMap();
  }

  /** Returns true if an object is seen within one of some boxes. */
  isWithin(mesh: Mesh, within: Box2[], camera: Camera, size: Vector2): boolean {
    const box = this.known.get(mesh) ?? boxOnScreen(mesh.geometry.boundingBox!, mesh, camera, size);
    this.known.set(mesh, box);
    return within.some((one) => one.intersectsBox(box));
  }
}

/** Side of the tiles in which the picture is drawn anew, in pixels of the page. */
const TILE = 64;
/** More than any picture has tiles in a row. */
const ROW = 1 << 16;

/** Tiles of the picture that are to be drawn anew. */
export class Tiles {
  private readonly marked = new Set<number>();

  get isEmpty(): boolean {
    return this.marked.size === 0;
  }

  clear(): void {
    this.marked.clear();
  }

  /** Marks all tiles that a box meets. */
  mark(box: Box2): void {
    if (box.isEmpty()) return;
    const { min, max } = box;
    for (let y = Math.floor(min.y / TILE); TILE * y < max.y; y += 1) {
      for (let x = Math.floor(min.x / TILE); TILE * x < max.x; x += 1) this.marked.add(ROW * y + x);
    }
  }

  /** Takes tiles beside each other out of those that are marked, `most` at most, and returns the box around them; null without any. */
  take(most: number): Box2 | null {
    const [first] = this.marked;
    if (first === undefined) return null;
    let [from, to] = [first, first];
    while (to + 1 - from < most && this.marked.has(from - 1)) from -= 1;
    while (to + 1 - from < most && this.marked.has(to + 1)) to += 1;
    for (let at = from; at <= to; at += 1) this.marked.delete(at);
    const corner = (at: number) => new Vector2(at % ROW, Math.floor(at / ROW)).multiplyScalar(TILE);
    return new Box2(corner(from), corner(to).addScalar(TILE));
  }

  /** Takes all tiles that are marked, in boxes. */
  *takeAll(): Generator<Box2> {
    for (let box = this.take(Infinity); box; box = this.take(Infinity)) yield box;
  }
}

/** Layer of a surface in patches. */
export const PATCHES = 4;

/** Patches along the longest side of a surface. */
const ALONG = 12;

/** A surface of many triangles in patches: a part of the picture needs few of them. */
export class SurfacePatches {
  readonly group = new Group();
  readonly all: Mesh[];

  /** Vertices stay those of the surface. */
  constructor(private readonly surface: Mesh) {
    const { index, attributes } = surface.geometry;
    this.all = patchesOf(index!.array, attributes.position!.array).map(({ triangles, bounds }) => {
      const geometry = new BufferGeometry();
      for (const [name, attribute] of Object.entries(attributes)) geometry.setAttribute(name, attribute as BufferAttribute);
      geometry.setIndex(new BufferAttribute(triangles, 1));
      geometry.boundingBox = bounds;
      const patch = new Mesh(geometry, surface.material);
      patch.layers.set(PATCHES);
      patch.frustumCulled = false;
      patch.matrixAutoUpdate = false;
      return patch;
    });
    this.group.add(...this.all);
  }

  /** Patches, where the surface is shown at all. */
  get shown(): Mesh[] {
    return this.surface.visible ? this.all : [];
  }
}

/** Box around the corners of triangles. Numbers alone: an object for every corner would hold the page. */
function boundsOf(triangles: ArrayLike<number>, positions: ArrayLike<number>): Box3 {
  const [low, high] = [new Vector3().setScalar(Infinity).toArray(), new Vector3().setScalar(-Infinity).toArray()];
  for (let at = 0; at < triangles.length; at += 1) {
    const from = 3 * triangles[at]!;
    for (let k = 0; k < 3; k += 1) {
      const x = positions[from + k]!;
      if (x < low[k]!) low[k] = x;
      if (x > high[k]!) high[k] = x;
    }
  }
  return new Box3(new Vector3(...low), new Vector3(...high));
}

/** Divides triangles by where their first corners are. */
export function patchesOf(triangles: ArrayLike<number>, positions: ArrayLike<number>): { triangles: Uint32Array<ArrayBuffer>; bounds: Box3 }[] {
  const whole = boundsOf(triangles, positions);
  const low = whole.min.toArray();
  const step = Math.max(...whole.getSize(new Vector3())) / ALONG || 1;
  const across = ALONG + 1;
  const cell = (vertex: number, k: 0 | 1 | 2) => Math.floor((positions[3 * vertex + k]! - low[k]) / step);
  const places = Uint32Array.from({ length: triangles.length / 3 }, (_, at) => {
    const vertex = triangles[3 * at]!;
    return (cell(vertex, 0) * across + cell(vertex, 1)) * across + cell(vertex, 2);
  });
  const counts = new Uint32Array(across ** 3);
  for (const place of places) counts[place]! += 1;
  const patches = Array.from(counts, (count) => new Uint32Array(3 * count));
  counts.fill(0);
  places.forEach((place, at) => {
    const to = 3 * counts[place]!;
    for (let k = 0; k < 3; k += 1) patches[place]![to + k] = triangles[3 * at + k]!;
    counts[place]! += 1;
  });
  return patches.filter(({ length }) => length > 0).map((patch) => ({ triangles: patch, bounds: boundsOf(patch, positions) }));
}

/** Longest and shortest that a frame should take [ms]: between them the number of triangles stays. */
const [LONGEST, SHORTEST] = [45, 25];
/** Milliseconds between two frames that do not follow each other. */
const PAUSE = 500;
/** Triangles of the first frame, fewest and most. */
const [FIRST, LEAST, MOST] = [24_000, 12_000, 1_000_000];

/** Number of triangles that a frame may draw anew, as the frames before tell it. */
export class Budget {
  triangles = FIRST;
  private before = 0;

  /** Hears of the time of a frame [ms]. */
  frame(now: number): void {
    const span = now - this.before;
    this.before = now;
    // After a pause it tells nothing.
    if (span > PAUSE) return;
    if (span > LONGEST) this.triangles = Math.max(this.triangles / 2, LEAST);
    else if (span < SHORTEST) this.triangles = Math.min(2 * this.triangles, MOST);
  }
}

/** Surfaces with their layer, and the scene around them. */
export interface Surfaces {
  scene: Scene;
  camera: Camera;
  /** All of them, of which a step shows some. */
  all: Mesh[];
  layer: number;
}

export const trianglesOf = (mesh: Mesh) => mesh.geometry.index!.count / 3;

/** Shows some surfaces alone while something is done. */
function showing(some: Mesh[], { all }: Surfaces, act: () => void): void {
  for (const one of all) one.visible = false;
  for (const one of some) one.visible = true;
  act();
  for (const one of all) one.visible = true;
}

/** Draws places of a picture anew without smooth edges, some surfaces a frame: what is seen stays as it was until all are drawn. */
export class Renewal {
  private at = 0;
  private readonly around = new Box2();

  /** `seen` are the surfaces within the places. */
  constructor(
    private readonly picture: RenewedPicture,
    private readonly surfaces: Surfaces,
    private readonly seen: Mesh[],
    readonly places: Box2[],
  ) {
    for (const place of places) this.around.union(place);
  }

  /** Draws about so many triangles; returns true when all are drawn and the picture is complete. */
  step(triangles: number): boolean {
    const { picture, surfaces, seen, around, at } = this;
    for (let left = triangles; left > 0 && this.at < seen.length; this.at += 1) left -= trianglesOf(seen[this.at]!);
    showing(seen.slice(at, this.at), surfaces, () => picture.drawQuickly(surfaces, surfaces.layer, around, at === 0));
    if (this.at < seen.length) return false;
    // Lines and all that is no surface.
    showing([], surfaces, () => picture.drawQuickly(surfaces, STILL, around, false));
    picture.keepQuickly(this.places);
    return true;
  }
}

export class RenewedPicture extends StillPicture {
  declare renderer: WebGLRenderer;
  declare target: WebGLRenderTarget | null;
  declare size: Vector2;
  /** Colours and depths of places that are drawn quickly: one sample a pixel, where the screen has four. */
  private quick: WebGLRenderTarget | null = null;
  private readonly quickScene = new Scene();
  private readonly quickMaterial: ShaderMaterial = sheetMaterial("#include <colorspace_fragment>");

  constructor(renderer: WebGLRenderer) {
    super(renderer);
    const sheet = new Mesh((this.sheet as Mesh).geometry, this.quickMaterial);
    sheet.frustumCulled = false;
    this.quickScene.add(sheet);
  }

  override prepare(): void {
    const before = this.target;
    super.prepare();
    if (this.target === before) return;
    const depthTexture = new DepthTexture(this.size.x, this.size.y, UnsignedIntType);
    depthTexture.minFilter = depthTexture.magFilter = NearestFilter;
    // Its colours have the steps of those on the screen.
    this.quick = new WebGLRenderTarget(this.size.x, this.size.y, { depthTexture, colorSpace: SRGBColorSpace });
    this.quickMaterial.uniforms.colours!.value = this.quick.texture;
    this.quickMaterial.uniforms.depths!.value = depthTexture;
  }

  override free(): void {
    super.free();
    this.quick?.depthTexture?.dispose();
    this.quick?.dispose();
    this.quick = null;
  }

  /** Compiles what an object is drawn with quickly: the first stock would wait for it. */
  compileQuickly(object: Object3D, { scene, camera }: Surfaces): void {
    this.renderer.setRenderTarget(this.quick);
    this.renderer.compile(object, camera, scene);
    this.renderer.setRenderTarget(null);
  }

  /** Draws what is shown of a layer within a box of the screen, unseen. */
  drawQuickly({ scene, camera }: Surfaces, layer: number, box: Box2, isFirst: boolean): void {
    camera.layers.set(layer);
    this.renderer.setRenderTarget(this.quick);
    this.renderer.autoClear = isFirst;
    this.within(box, this.quick!, () => this.renderer.render(scene, camera));
    this.renderer.autoClear = true;
    this.renderer.setRenderTarget(null);
    this.seeAll(camera);
  }

  /** Puts places that were drawn quickly into the picture. */
  keepQuickly(places: Box2[]): void {
    const target = this.target!;
    this.uncover();
    for (const place of places) {
      this.within(place, target, () => {
        this.putBack(this.quickScene);
        this.renderer.setRenderTarget(target);
        this.putBack(this.quickScene);
        this.renderer.setRenderTarget(null);
      });
    }
    this.renderer.copyFramebufferToTexture(this.colours!);
  }

  /** Draws some surfaces and what stands still beside them anew within a box of the screen, with smooth edges. */
  renew(surfaces: Surfaces, seen: Mesh[], box: Box2): void {
    const { scene, camera, layer } = surfaces;
    this.uncover();
    camera.layers.set(STILL);
    camera.layers.enable(layer);
    showing(seen, surfaces, () =>
      this.within(box, this.target!, () => {
        this.beginDepths(scene);
        this.renderer.render(scene, camera);
        this.endDepths(scene);
        this.renderer.render(scene, camera);
      }),
    );
    this.renderer.copyFramebufferToTexture(this.colours!);
    camera.layers.disable(layer);
    this.seeAll(camera);
  }

  private seeAll(camera: Camera): void {
    camera.layers.disableAll();
    for (const seen of [STILL, MOVING, SURFACE]) camera.layers.enable(seen);
  }

  /** Takes away what moves: colours are copied from the screen. */
  private uncover(): void {
    this.within(this.covered, this.target!, () => this.putBack(this.scene));
    this.covered.makeEmpty();
  }

  private putBack(sheet: Scene): void {
    const { clippingPlanes } = this.renderer;
    this.renderer.clippingPlanes = [];
    this.renderer.render(sheet, this.camera);
    this.renderer.clippingPlanes = clippingPlanes;
  }

  /** Draws within a box of the screen, and of a target. */
  private within({ min, max }: Box2, target: WebGLRenderTarget, draw: () => void): void {
    if (max.x <= min.x || max.y <= min.y) return;
    const { renderer } = this;
    const ratio = renderer.getPixelRatio();
    renderer.setScissor(min.x, min.y, max.x - min.x, max.y - min.y);
    renderer.setScissorTest(true);
    target.scissor.set(min.x, min.y, max.x - min.x, max.y - min.y).multiplyScalar(ratio);
    target.scissorTest = true;
    draw();
    target.scissorTest = false;
    renderer.setScissorTest(false);
  }
}
