// A plain model of a machine, drawn from its chain: a body for every link, each carried by the one before.

import {
  BoxGeometry,
  CylinderGeometry,
  DoubleSide,
  Group,
  Matrix4,
  Mesh,
  MeshStandardMaterial,
  Quaternion,
  Vector3,
} from "three";
import type { Link, Machine } from "./messages";

const UP = new Vector3(0, 0, 1);
const ALONG = new Vector3(0, 1, 0);

/** Okabe and Ito, as the charts colour the axes. */
const HUES = ["#0072b2", "#009e73", "#56b4e9", "#d55e00", "#cc79a7"];

const vector = (numbers: readonly number[]) => new Vector3().fromArray(numbers as number[]);

/** Motion of a link: of the tool relative to the workpiece. */
function motion(link: Link, q: number): Matrix4 {
  const direction = vector(link.direction);
  if (!link.rotary) return new Matrix4().makeTranslation(direction.multiplyScalar(q));
  const point = vector(link.point);
  const back = new Matrix4().makeTranslation(point.clone().negate());
  const turn = new Matrix4().makeRotationAxis(direction.normalize(), q);
  return new Matrix4().makeTranslation(point).multiply(turn).multiply(back);
}

function body(colour: string, opacity = 1): MeshStandardMaterial {
  return new MeshStandardMaterial({
    color: colour,
    roughness: 0.7,
    metalness: 0.1,
    transparent: opacity < 1,
    opacity,
    depthWrite: opacity === 1,
    side: DoubleSide,
  });
}

/** Cylinder from one point to another. */
function rod(from: Vector3, to: Vector3, radius: number, material: MeshStandardMaterial): Mesh {
  const along = to.clone().sub(from);
  const mesh = new Mesh(new CylinderGeometry(radius, radius, along.length(), 48), material);
  mesh.position.copy(from).addScaledVector(along, 0.5);
  mesh.quaternion.copy(new Quaternion().setFromUnitVectors(ALONG, along.normalize()));
  return mesh;
}

/** Box that is long in one direction. */
function bar(centre: Vector3, direction: Vector3, [length, width]: [number, number], material: MeshStandardMaterial): Mesh {
  const mesh = new Mesh(new BoxGeometry(width, width, length), material);
  mesh.position.copy(centre);
  mesh.quaternion.copy(new Quaternion().setFromUnitVectors(UP, direction.clone().normalize()));
  return mesh;
}

export class MachineModel {
  readonly group = new Group();
  /** Machine from workpiece, all axes at zero. */
  private readonly placed: Matrix4;
  private readonly workpieceBodies: Group[];
  private readonly toolBodies: Group[];

  /** `radius` is that of the part, `low` the distance of its lowest point from the workpiece origin along the table. */
  constructor(
    private readonly machine: Machine,
    private readonly radius: number,
    private readonly low: number,
  ) {
    const [x, y, z] = machine.rotation;
    const { origin } = machine;
    this.placed = new Matrix4().set(...x, origin[0], ...y, origin[1], ...z, origin[2], 0, 0, 0, 1);
    // Body k is carried by link k; the bodies of the workpiece side begin at the workpiece.
    this.workpieceBodies = machine.workpiece_side.map((link, k) => this.workpieceBody(link, k));
    this.toolBodies = machine.tool_side.map((link, k) => this.toolBody(link, k));
    const spindle = this.spindle();
    (this.toolBodies.at(-1) ?? this.group).add(spindle);
    this.group.add(...this.workpieceBodies, ...this.toolBodies);
    for (const one of this.group.children) one.matrixAutoUpdate = false;
    if (!this.toolBodies.length) this.group.add(spindle);
  }

  private colour(link: Link): string {
    return HUES[link.axis % HUES.length]!;
  }

  /** Where a rotary link of the workpiece side is drawn: below the part, on its own axis. */
  private tableCentre(link: Link): Vector3 {
    const [point, direction] = [vector(link.point), vector(link.direction).normalize()];
    const origin = vector(this.machine.origin);
    return point.addScaledVector(direction, origin.sub(vector(link.point)).dot(direction));
  }

  private workpieceBody(link: Link, k: number): Group {
    const group = new Group();
    const direction = vector(link.direction).normalize();
    const material = body(this.colour(link), 0.55);
    const size = 1.25 * this.radius + 12 * k;
    const centre = this.tableCentre(link);
    const tool = vector(this.machine.tool_axis);
    const isTable = Math.abs(direction.dot(tool)) > 0.5;
    if (link.rotary && isTable) {
      const top = centre.addScaledVector(tool, this.low - 4 - 24 * k);
      group.add(rod(top, top.clone().addScaledVector(tool, -20), size, material));
    } else if (link.rotary) {
      // A cradle: journals on both sides, and a beam below that joins them.
      for (const side of [-1, 1]) {
        const inner = centre.clone().addScaledVector(direction, side * size * 1.1);
        group.add(rod(inner, inner.clone().addScaledVector(direction, side * 0.25 * size), 0.3 * size, material));
        const foot = centre.clone().addScaledVector(direction, side * size * 1.12).addScaledVector(tool, this.low - 34);
        group.add(rod(foot, inner, 0.1 * size, material));
      }
      const below = centre.clone().addScaledVector(tool, this.low - 44 - 24 * k);
      group.add(bar(below, direction, [2.4 * size, 0.3 * size], material));
    } else {
      const below = vector(this.machine.origin).addScaledVector(tool, this.low - 60 - 30 * k);
      group.add(bar(below, direction, [2.6 * size, 26], material));
    }
    return group;
  }

  private toolBody(link: Link, k: number): Group {
    const group = new Group();
    const [gauge, tool] = [vector(this.machine.gauge), vector(this.machine.tool_axis)];
    const above = this.machine.tool_side.length - k;
    const material = body(this.colour(link), 0.55);
    if (link.rotary) {
      const [point, direction] = [vector(link.point), vector(link.direction).normalize()];
      const half = 0.3 * this.radius + 20 * above;
      const [from, to] = [-half, half].map((by) => point.clone().addScaledVector(direction, by));
      group.add(rod(from!, to!, 34, material));
      group.add(rod(point, gauge, 22, material));
    } else {
      const centre = gauge.addScaledVector(tool, 170 + 46 * above);
      group.add(bar(centre, vector(link.direction), [1.6 * this.radius + 60, 44], material));
    }
    return group;
  }

  private spindle(): Group {
    const group = new Group();
    const [gauge, tool] = [vector(this.machine.gauge), vector(this.machine.tool_axis)];
    const material = body("#6b7785", 0.7);
    const nose = gauge.clone().addScaledVector(tool, 40);
    group.add(rod(gauge, nose, 32, material), rod(nose, gauge.clone().addScaledVector(tool, 190), 52, material));
    return group;
  }

  /** Machine coordinates from those of the workpiece at a position of the axes. */
  machineFromWorkpiece(axes: number[]): Matrix4 {
    const chain = new Matrix4();
    for (const link of this.machine.workpiece_side) chain.multiply(motion(link, axes[link.axis]!));
    return chain.invert().multiply(this.placed);
  }

  /** Moves the bodies; the group is in machine coordinates. */
  place(axes: number[]): void {
    const { workpiece_side: workpiece, tool_side: tool } = this.machine;
    // The body of a link on the workpiece side moves against the link, and with all between it and the bed.
    const back = new Matrix4();
    for (let k = workpiece.length - 1; k >= 0; k -= 1) {
      const link = workpiece[k]!;
      back.copy(back.clone().multiply(motion(link, axes[link.axis]!).invert()));
      this.workpieceBodies[k]!.matrix.copy(back);
    }
    const forward = new Matrix4();
    tool.forEach((link, k) => {
      forward.multiply(motion(link, axes[link.axis]!));
      this.toolBodies[k]!.matrix.copy(forward);
    });
  }
}
