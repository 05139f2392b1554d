// The 3-D view of the studio: the report's view with the machine, a second path, a frame to drag, a section plane, and a ruler.

import {
  Box2,
  Box3,
  BoxGeometry,
  type BufferAttribute,
  BufferGeometry,
  Group,
  Line,
  LineBasicMaterial,
  LineSegments,
  Matrix4,
  Mesh,
  type MeshStandardMaterial,
  type Object3D,
  Plane,
  Quaternion,
  Raycaster,
  Vector2,
  Vector3,
  type WebGLRenderer,
} from "three";
import { BufferAttribute as Attribute } from "three";
import { SURFACE } from "../../viewer/src/layers.js";
import { TOOL_COLOUR, View, makeRenderer, setMoving, toolMesh } from "../../viewer/src/scene.js";
import type { ComparedPaths } from "./compare";
import { lightCorners } from "./cornerlit";
import { FacePainter } from "./faces";
import { PartFrame, type Placement } from "./frame";
import { MachineModel } from "./machine";
import type { Bricks, FaceInfo, Machine, PartFaces } from "./messages";
import { Budget, PATCHES, Renewal, RenewedPicture, ScreenBoxes, type Surfaces, SurfacePatches, Tiles, boxOnScreen, trianglesOf } from "./renewed";
import { StockSurface, bricksOf, stockMaterial } from "./stock";
import type { ToolPlace } from "./timeline";

/** Directions in which a section looks. */
const NORMALS: Record<string, [number, number, number]> = { x: [-1, 0, 0], y: [0, 1, 0], z: [0, 0, -1] };

/** Farthest that the machine is looked at from, in radii of the part. */
const WHOLE_MACHINE = 4.5;
/** The same while the part is placed on it. */
const AROUND_PART = 2;

/** First and second of two programs and what they share, on light and on dark: Okabe and Ito, told apart by colour-blind eyes. */
const SIDES = { light: { first: "#0072b2", second: "#d55e00", shared: "#6b7785" }, dark: { first: "#56b4e9", second: "#ffa64d", shared: "#8e99a5" } };

const isDark = () => matchMedia("(prefers-color-scheme: dark)").matches;

/** Paths of two programs, and the tools of the second. */
export interface SecondProgram {
  paths: ComparedPaths;
  tools: number[][][];
}

/** Gives everything in an object one colour. */
const tint = (object: Object3D, colour: string) =>
  object.traverse((one) => ((one as Mesh).material as MeshStandardMaterial | LineBasicMaterial | undefined)?.color.set(colour));

const lineSegments = (ends: Float32Array) => {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new Attribute(ends, 3));
  return new LineSegments(geometry, new LineBasicMaterial({ transparent: true, opacity: 0.9 }));
};

/**
 * Brings lines nearer to the eye by half a hundredth of its distance, in depth alone: points on a face lie below its flat triangles
 * where it is hollow.
 */
function bringForward(lines: LineSegments): LineSegments {
  (lines.material as LineBasicMaterial).onBeforeCompile = (shader) => {
    const project = "#include <project_vertex>";
    shader.vertexShader = shader.vertexShader.replace(project, `${project}\n  gl_Position.z -= 1e-4 * gl_Position.w;`);
  };
  return lines;
}

/** Milliseconds for which bricks of stock are taken before a frame is drawn. */
const STEP = 3;

/** Triangles that are drawn quickly in the time of a smooth one: that has four samples a pixel, and depths are drawn by themselves. */
const SMOOTH = 5;

/** Least triangles a frame while the tool stands still: frames may take longer, and the stock is sooner there. */
const ALONE = 80_000;

/** Milliseconds without a change after which edges are drawn smoothly. */
const REST = 200;

/** Frees the memory that an object has on the graphics card. */
const free = (object: Object3D) => object.traverse((one) => (one as Partial<Mesh>).geometry?.dispose());

/** Size of the first picture, which nobody sees, px. */
const SMALL = 16;

let shared: { renderer: WebGLRenderer; still: RenewedPicture } | null = null;

function makeShared(): { renderer: WebGLRenderer; still: RenewedPicture } {
  const renderer = makeRenderer();
  return { renderer, still: new RenewedPicture(renderer) };
}

/** Makes the renderer and compiles what it draws with, while the page has nothing else to do: a result would wait for it. */
export async function warmUp(): Promise<void> {
  if (shared) return;
  const nothing = { low: [0, 0, 0], high: [1, 1, 1], positions: new Float32Array(9), deviation: new Int16Array(), count: 3, triangles: new Uint32Array([0, 1, 2]), step: 0, measured: 0 };
  const path = { points: new Float32Array(20), pieces: [{ kind: "cut", start: 0, count: 2, tool: 0 }], count: 2, contacts: false };
  const outline = [[0, 0], [1, 0], [1, 1]];
  const stage = new Stage(document.createElement("div"), { budget: { total: 0, gouge: 0 }, surface: nothing, path, tools: [outline], fixtures: null, check: { method: "", places: [] } });
  const pause = () => new Promise((resolve) => setTimeout(resolve, 40));
  // A result may be opened meanwhile: its stage has the renderer then.
  const isStill = () => stage.renderer.domElement.parentElement === stage.host;
  // One by one: compiled together, they would hold the page for half a second.
  const stock = new Mesh(new BoxGeometry(), stockMaterial(1));
  const drawn = [stage.mesh, stage.lines.tip, stage.tool, stage.marker, stock] as Mesh[];
  for (const one of drawn) {
    await pause();
    stage.renderer.compile(one, stage.camera, stage.scene);
  }
  await pause();
  stage.still.compile(stage.scene, stage.camera);
  // Graphics without a card compile once more when they draw.
  if (isStill()) stage.renderer.setSize(SMALL, SMALL);
  stage.part.add(stock);
  for (const changes of ["some", "moving"] as const) {
    await pause();
    if (isStill()) stage.renderAtOnce(changes);
  }
  // Places that are drawn anew have a target of their own.
  const { still, scene, camera } = stage;
  const surfaces = { scene, camera, all: [], layer: SURFACE };
  for (const one of [stage.mesh, stage.lines.tip, stage.marker, stock] as Mesh[]) {
    await pause();
    if (isStill()) still.compileQuickly(one, surfaces);
  }
  await pause();
  const whole = new Box2(new Vector2(), new Vector2(SMALL, SMALL));
  if (isStill()) new Renewal(still, surfaces, [stage.mesh], [whole]).step(Infinity);
  if (isStill()) stage.dispose();
}

export class Stage extends View {
  declare centre: Vector3;
  declare radius: number;
  declare still: RenewedPicture;
  private machine: MachineModel | null = null;
  private machineShown = false;
  private machineStill = false;
  private axes: number[] | null = null;
  private ruler: Line | null = null;
  private painter: FacePainter | null = null;
  /** Passes while they are placed, by face. */
  private placed: Map<number, LineSegments> | null = null;
  private second: { paths: Record<keyof ComparedPaths, LineSegments>; tool: Group } | null = null;
  private frame: PartFrame | null = null;
  private stock: StockSurface | null = null;
  /** Around what has changed of the stock since it was drawn. */
  private renewed: Box3[] = [];
  /** All bricks of a change are there: it can be drawn. */
  private isRenewed = false;
  /** Tiles of the picture that are not up to date, and those that are but for smooth edges. */
  private readonly stale = new Tiles();
  private readonly rough = new Tiles();
  private readonly boxes = new ScreenBoxes();
  private readonly budget = new Budget();
  private renewal: Renewal | null = null;
  private resting = 0;
  /** When the tool moved last [ms]. */
  private moved = -Infinity;
  private isResting = false;
  private patches: SurfacePatches | null = null;
  private readonly bench = new Group();

  /** Throws where there is no WebGL. All stages share a renderer: only one is on the page. */
  constructor(host: HTMLElement, data: object) {
    shared ??= makeShared();
    super(host, data, shared.renderer, shared.still);
    lightCorners(this.tool as Group);
    this.renderer.clippingPlanes = [];
    this.bench.matrixAutoUpdate = false;
    this.part.matrixAutoUpdate = false;
    this.scene.add(this.bench);
  }

  /** Draws a machine from its chain. */
  setMachine(machine: Machine): void {
    const { low, high, count } = this.data.surface as { low: number[]; high: number[]; count: number };
    const [x, y, z] = machine.rotation;
    // The table lies below the lowest corner of the part, seen along the tool.
    const along = (corner: number[]) =>
      [x, y, z].reduce((sum, row, k) => sum + machine.tool_axis[k]! * row.reduce((dot, r, j) => dot + r * corner[j]!, 0), 0);
    const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((bits) => [0, 1, 2].map((k) => ((bits >> k) & 1 ? high : low)[k]!));
    const lowest = count > 0 ? Math.min(...corners.map(along)) : -this.radius;
    this.machine = new MachineModel(machine, this.radius, lowest);
    this.bench.clear();
    this.bench.add(this.machine.group);
    this.arrange();
    this.draw();
  }

  /** Shows the machine or hides it. */
  showMachine(shown: boolean): void {
    this.machineShown = shown;
    this.arrange();
    this.draw();
  }

  /** Keeps the bed of the machine still on the screen, or the workpiece. */
  keepMachineStill(still: boolean): void {
    this.machineStill = still;
    this.arrange();
    this.fit();
  }

  place(tool: ToolPlace, axes: number[] | null): void {
    this.axes = axes;
    this.moved = performance.now();
    this.stir();
    this.placeTool(tool);
    this.arrange();
    // Without them the tool alone has moved.
    if (this.bench.visible || this.machineStill) this.drawChanging();
  }

  private arrange(): void {
    if (this.frame) return;
    const still = this.machineStill && this.machine && this.axes;
    this.bench.visible = this.machineShown && this.machine !== null && this.axes !== null;
    if (this.machine && this.axes) {
      this.machine.place(this.axes);
      const machineFromWorkpiece = this.machine.machineFromWorkpiece(this.axes);
      this.part.matrix.copy(still ? machineFromWorkpiece : new Matrix4());
      this.bench.matrix.copy(still ? new Matrix4() : machineFromWorkpiece.clone().invert());
    }
    this.scene.updateMatrixWorld(true);
  }

  /** Looks at the part, or at the whole machine where it stands still. */
  override fit(direction?: number[]): void {
    const [centre, radius] = [this.centre.clone(), this.radius];
    if (this.part) this.centre.applyMatrix4(this.part.matrix);
    if (this.frame) this.radius *= AROUND_PART;
    else if (this.machineStill && this.machineShown) this.radius *= WHOLE_MACHINE;
    super.fit(direction as [number, number, number] | undefined);
    this.centre.copy(centre);
    this.radius = radius;
  }

  // Passes while they are placed.

  /** Draws the passes of faces, in place of the path and of what was drawn of these faces before. */
  showPlaced(faces: Map<number, Float32Array>): void {
    this.placed ??= new Map();
    this.drawChanging();
    this.part.remove(...Object.values(this.lines as Record<string, Object3D>));
    for (const [face, ends] of faces) {
      const [before, lines] = [this.placed.get(face), bringForward(lineSegments(ends))];
      if (before) this.part.remove(before);
      if (before) free(before);
      this.placed.set(face, lines);
      this.part.add(lines);
    }
    this.theme();
  }

  /** Takes the passes away that were drawn while they were placed. */
  endPlaced(): void {
    if (!this.placed) return;
    for (const lines of this.placed.values()) {
      this.part.remove(lines);
      free(lines);
    }
    this.placed = null;
    this.part.add(...Object.values(this.lines as Record<string, Object3D>));
    this.draw();
  }

  // Stock as it is cut.

  /** Starts with stock of which nothing is known yet; null takes it away. */
  setStock(stock: StockSurface | null): void {
    if (this.stock) {
      this.part.remove(this.stock.group);
      free(this.stock.group);
    }
    this.stock = stock;
    if (stock) this.part.add(stock.group);
    this.draw();
  }

  showStock(shown: boolean): void {
    if (!this.stock) return;
    this.stock.group.visible = shown;
    this.draw();
  }

  /** Takes bricks that have changed, some a frame: the page is never held up. */
  async changeStock(bricks: Bricks): Promise<void> {
    const { stock } = this;
    if (!stock) return;
    let begin = performance.now();
    for (const brick of bricksOf(bricks)) {
      this.renewed.push(...stock.take(brick));
      if (performance.now() - begin < STEP) continue;
      await new Promise(requestAnimationFrame);
      if (this.stock !== stock) return;
      begin = performance.now();
    }
    this.scene.updateMatrixWorld(true);
    this.isRenewed = true;
    this.stir();
    this.drawMoving();
    // It is seen before more is asked for.
    do await new Promise(requestAnimationFrame);
    while (this.stock === stock && (this.isRenewed || this.renewal || !this.stale.isEmpty));
  }

  /** Something moves: smooth edges wait until nothing has for a moment. */
  private stir(): void {
    this.isResting = false;
    clearTimeout(this.resting);
    this.resting = window.setTimeout(() => {
      this.isResting = true;
      if (!this.rough.isEmpty) this.drawMoving();
    }, REST);
  }

  /** Draws places in which the stock has changed anew, some triangles a frame, where the rest of the picture is as it was. */
  private renewStill(): void {
    const size = this.renderer.getSize(new Vector2());
    if (this.isRenewed && this.stock?.group.visible) for (const box of this.renewed) this.stale.mark(boxOnScreen(box, this.part, this.camera, size));
    if (this.isRenewed) this.renewed = [];
    this.isRenewed = false;
    const isWaiting = this.renewal || !this.stale.isEmpty;
    if (!isWaiting && (!this.isResting || this.rough.isEmpty)) return;
    this.budget.frame(performance.now());
    this.patches ??= this.makePatches();
    if (isWaiting) this.renewQuickly(size);
    else this.renewSmoothly(size);
    const isWhole = !this.renewal && this.rough.isEmpty;
    this.host.dataset.picture = isWhole ? "whole" : "coarse";
    if (this.renewal || (this.isResting && !isWhole)) this.drawMoving();
  }

  private renewQuickly(size: Vector2): void {
    if (!this.renewal) {
      const places = [...this.stale.takeAll()];
      this.renewal = new Renewal(this.still, this.surfaces, this.seenWithin(places, size), places);
    }
    const isAlone = performance.now() - this.moved > REST;
    if (!this.renewal.step(Math.max(this.budget.triangles, isAlone ? ALONE : 0))) return;
    for (const place of this.renewal.places) this.rough.mark(place);
    this.renewal = null;
  }

  private renewSmoothly(size: Vector2): void {
    let left = this.budget.triangles / SMOOTH;
    for (let box = this.rough.take(1); box; box = left > 0 ? this.rough.take(1) : null) {
      const seen = this.seenWithin([box], size);
      this.still.renew(this.surfaces, seen, box);
      for (const one of seen) left -= trianglesOf(one);
    }
  }

  private get surfaces(): Surfaces {
    return { scene: this.scene, camera: this.camera, all: [...this.stock!.meshes, ...this.patches!.all], layer: PATCHES };
  }

  private seenWithin(places: Box2[], size: Vector2): Mesh[] {
    const shown = [...this.stock!.meshes, ...this.patches!.shown];
    return shown.filter((one) => this.boxes.isWithin(one, places, this.camera, size));
  }

  private makePatches(): SurfacePatches {
    const patches = new SurfacePatches(this.mesh as Mesh);
    this.part.add(patches.group);
    this.scene.updateMatrixWorld(true);
    return patches;
  }

  override renderAtOnce(changes: string | null): void {
    this.renewChanged(changes);
    super.renderAtOnce(changes);
  }

  override renderGradually(changes: string | null): void {
    const { isBusy } = this.gradual as unknown as { isBusy: boolean };
    // What is on its way may have the stock from before: the change is drawn into it when it is complete.
    if (this.isRenewed && isBusy) requestAnimationFrame(() => this.drawMoving());
    else this.renewChanged(changes);
    super.renderGradually(changes);
  }

  /** Draws what has changed of the stock, unless all is drawn. */
  private renewChanged(changes: string | null): void {
    if (changes === "moving" && this.still.isFresh) return this.renewStill();
    for (const one of [this.stale, this.rough, this.boxes]) one.clear();
    this.renewal = null;
    // Of a change that is not complete more is to come.
    if (this.isRenewed) this.renewed = [];
    this.isRenewed = false;
  }

  // A second program.

  /** Draws the path of a second program beside the first, and where they differ each in its colour; null takes it away. */
  setSecond(second: SecondProgram | null): void {
    for (const one of this.second ? [...Object.values(this.second.paths), this.second.tool] : []) {
      this.part.remove(one);
      free(one);
    }
    this.second = null;
    if (second) {
      const { shared, first, second: other } = second.paths;
      const paths = { shared: lineSegments(shared), first: lineSegments(first), second: lineSegments(other) };
      const tool = new Group();
      tool.add(...second.tools.map(toolMesh));
      lightCorners(tool);
      setMoving(tool);
      this.part.add(...Object.values(paths), tool);
      this.second = { paths, tool };
    }
    this.theme();
  }

  placeSecond({ tip, axis, tool: number }: ToolPlace): void {
    if (!this.second) return;
    const { tool } = this.second;
    tool.position.fromArray(tip);
    tool.quaternion.copy(new Quaternion().setFromUnitVectors(new Vector3(0, 0, 1), new Vector3().fromArray(axis)));
    tool.children.forEach((one, at) => (one.visible = at === number));
    this.drawMoving();
  }

  showSecond(shown: boolean): void {
    if (!this.second) return;
    this.second.paths.second.visible = this.second.tool.visible = shown;
    this.draw();
  }

  override theme(): void {
    super.theme(isDark());
    const colours = SIDES[isDark() ? "dark" : "light"];
    tint(this.tool as Group, this.second ? colours.first : TOOL_COLOUR);
    // Faces that are cut are blue.
    for (const lines of this.placed?.values() ?? []) tint(lines, colours.second);
    if (!this.second) return;
    const { paths, tool } = this.second;
    for (const side of ["shared", "first", "second"] as const) tint(paths[side], colours[side]);
    tint(tool, colours.second);
    this.draw();
  }

  // Faces of a part, and the place of the part on the machine.

  /** Shows the edges of a part, and its faces as things to pick. */
  showFaces(part: PartFaces): void {
    const { position, normal } = (this.mesh as Mesh).geometry.attributes;
    this.painter = new FacePainter(part, position as BufferAttribute, normal as BufferAttribute);
    this.part.add(this.painter.group);
    this.draw();
  }

  /** Face under a point of the screen; null beside the part. */
  faceAt(clientX: number, clientY: number): FaceInfo | null {
    if (this.frame?.isHeld) return null;
    const box = this.renderer.domElement.getBoundingClientRect();
    const spot = new Vector2((2 * (clientX - box.left)) / box.width - 1, 1 - (2 * (clientY - box.top)) / box.height);
    const ray = new Raycaster();
    ray.layers.enable(SURFACE);
    ray.setFromCamera(spot, this.camera);
    const triangle = ray.intersectObject(this.mesh as Mesh)[0]?.faceIndex;
    return triangle === undefined || triangle === null ? null : (this.painter?.faceOf(triangle) ?? null);
  }

  pickFaces(numbers: number[]): void {
    this.painter?.pick(numbers);
    this.draw();
  }

  hoverFace(face: FaceInfo | null): void {
    this.painter?.hover(face);
    this.draw();
  }

  /**
   * Shows the part on a machine with all axes at zero, with a frame at its origin that is dragged; `onMove` gets every
   * place, `onPlace` the one at which it is let go.
   */
  startPlacing(machine: Machine, placement: Placement, onMove: (at: Placement) => void, onPlace: (at: Placement) => void): void {
    this.endPlacing();
    this.setMachine({ ...machine, origin: placement.origin, rotation: [[1, 0, 0], [0, 1, 0], [0, 0, 1]] });
    this.machine!.place([0, 0, 0, 0, 0]);
    this.bench.visible = true;
    this.bench.matrix.identity();
    this.frame = new PartFrame(this.camera, this.renderer.domElement, this.controls, (at) => {
      this.part.matrix.copy(this.frame!.matrix);
      this.scene.updateMatrixWorld(true);
      this.drawChanging();
      if (at.isDone) onPlace(at.placement);
      else onMove(at.placement);
    });
    this.scene.add(this.frame.group);
    this.setPlacement(placement);
    this.fit();
  }

  /** Puts the part where a job has it. */
  setPlacement(placement: Placement): void {
    if (!this.frame || this.frame.isHeld) return;
    this.frame.set(placement);
    this.part.matrix.copy(this.frame.matrix);
    this.scene.updateMatrixWorld(true);
    this.draw();
  }

  /** Moves or turns by dragging. */
  dragBy(mode: "translate" | "rotate"): void {
    this.frame?.setMode(mode);
    this.draw();
  }

  endPlacing(): void {
    if (!this.frame) return;
    this.scene.remove(this.frame.group);
    this.frame.dispose();
    this.frame = null;
    this.bench.visible = false;
    this.part.matrix.identity();
    this.scene.updateMatrixWorld(true);
    this.fit();
  }

  // Section and ruler.

  /** Cuts everything away in front of a plane: a `share` of 1 keeps all, one of 0 nothing; null for no section. */
  section(axis: string | null, share: number): void {
    const normal = axis === null ? null : NORMALS[axis];
    if (!normal) {
      this.renderer.clippingPlanes = [];
    } else {
      const point = this.centre.clone().addScaledVector(new Vector3(...normal), this.radius * (1 - 2 * share));
      const plane = new Plane().setFromNormalAndCoplanarPoint(new Vector3(...normal), point);
      this.renderer.clippingPlanes = [plane.applyMatrix4(this.part.matrix)];
    }
    this.drawChanging();
  }

  /** Draws a line through points of the part; without two of them it takes the line away. */
  measureLine(points: number[][]): void {
    if (this.ruler) this.part.remove(this.ruler);
    this.ruler = null;
    if (points.length > 1) {
      const geometry = new BufferGeometry().setFromPoints(points.map((point) => new Vector3().fromArray(point)));
      this.ruler = new Line(geometry, new LineBasicMaterial({ color: "#ff2bd6", depthTest: false, transparent: true }));
      this.ruler.renderOrder = 8;
      this.part.add(this.ruler);
    }
    this.draw();
  }

  /** Frees the memory of the graphics card: a page may open many results. */
  dispose(): void {
    this.stock = null;
    clearTimeout(this.resting);
    this.endPlacing();
    (this.gradual as { dispose(): void } | null)?.dispose();
    this.still.free();
    free(this.scene as Object3D);
    ((this.mesh as Mesh).material as MeshStandardMaterial).map?.dispose();
    this.renderer.domElement.remove();
    this.observer.disconnect();
    this.controls.dispose();
  }
}
