// The 3-D view of the studio: the report's view with the machine, a section plane, and a ruler.

import { type BufferAttribute, BufferGeometry, Group, Line, LineBasicMaterial, Matrix4, type Mesh, Plane, Raycaster, Vector2, Vector3 } from "three";
import { View } from "../../viewer/src/scene.js";
import { FacePainter } from "./faces";
import { MachineModel } from "./machine";
import type { FaceInfo, Machine, PartFaces } from "./messages";
import type { ToolPlace } from "./timeline";

/** Directions in which a section looks. */
const NORMALS: Record<string, [number, number, number]> = { x: [-1, 0, 0], y: [0, 1, 0], z: [0, 0, -1] };

/** Farthest that the machine is looked at from, in radii of the part. */
const WHOLE_MACHINE = 4.5;

export interface Ruler {
  from: number[];
  to: number[];
}

export class Stage extends View {
  declare centre: Vector3;
  declare radius: number;
  private machine: MachineModel | null = null;
  private machineShown = false;
  private machineStill = false;
  private axes: number[] | null = null;
  private ruler: Line | null = null;
  private painter: FacePainter | null = null;
  private readonly bench = new Group();

  constructor(host: HTMLElement, data: object) {
    super(host, data);
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
  }

  /** Shows the machine or hides it. */
  showMachine(shown: boolean): void {
    this.machineShown = shown;
    this.arrange();
  }

  /** Keeps the bed of the machine still on the screen, or the workpiece. */
  keepMachineStill(still: boolean): void {
    this.machineStill = still;
    this.arrange();
    this.fit();
  }

  place(tool: ToolPlace, axes: number[] | null): void {
    this.axes = axes;
    this.placeTool(tool);
    this.arrange();
  }

  private arrange(): void {
    const still = this.machineStill && this.machine && this.axes;
    this.bench.visible = this.machineShown && this.machine !== null && this.axes !== null;
    if (this.machine && this.axes) {
      this.machine.place(this.axes);
      const machineFromWorkpiece = this.machine.machineFromWorkpiece(this.axes);
      this.part.matrix.copy(still ? machineFromWorkpiece : new Matrix4());
      this.bench.matrix.copy(still ? new Matrix4() : machineFromWorkpiece.clone().invert());
    }
    this.scene.updateMatrixWorld(true);
    this.draw();
  }

  /** Looks at the part, or at the whole machine where it stands still. */
  override fit(direction?: number[]): void {
    const [centre, radius] = [this.centre.clone(), this.radius];
    if (this.part) this.centre.applyMatrix4(this.part.matrix);
    if (this.machineStill && this.machineShown) this.radius *= WHOLE_MACHINE;
    super.fit(direction as [number, number, number] | undefined);
    this.centre.copy(centre);
    this.radius = radius;
  }

  /** Shows the edges of a part, and its faces as things to pick. */
  showFaces(part: PartFaces): void {
    const { position, normal } = (this.mesh as Mesh).geometry.attributes;
    this.painter = new FacePainter(part, position as BufferAttribute, normal as BufferAttribute);
    this.part.add(this.painter.group);
    this.draw();
  }

  /** Face under a point of the screen; null beside the part. */
  faceAt(clientX: number, clientY: number): FaceInfo | null {
    const box = this.renderer.domElement.getBoundingClientRect();
    const spot = new Vector2((2 * (clientX - box.left)) / box.width - 1, 1 - (2 * (clientY - box.top)) / box.height);
    const ray = new Raycaster();
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
    this.draw();
  }

  /** Draws a line between two points of the part; null takes it away. */
  measureLine(ruler: Ruler | null): void {
    if (this.ruler) this.part.remove(this.ruler);
    this.ruler = null;
    if (ruler) {
      const geometry = new BufferGeometry().setFromPoints([ruler.from, ruler.to].map((point) => new Vector3().fromArray(point)));
      this.ruler = new Line(geometry, new LineBasicMaterial({ color: "#ff2bd6", depthTest: false, transparent: true }));
      this.ruler.renderOrder = 8;
      this.part.add(this.ruler);
    }
    this.draw();
  }

  /** Frees the graphics card: a page may open many results. */
  dispose(): void {
    this.scene.traverse((object: object) => {
      if ("geometry" in object) (object.geometry as BufferGeometry).dispose();
    });
    this.renderer.dispose();
    this.renderer.forceContextLoss();
    this.renderer.domElement.remove();
    this.controls.dispose();
  }
}
