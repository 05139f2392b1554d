// The frame at the origin of a part that is dragged: along its axes, or about them.

import { type Camera, Euler, Group, MathUtils, Matrix4, Object3D } from "three";
import { TransformControls } from "three/addons/controls/TransformControls.js";

/** Place of a part on a machine with all axes at zero, as a job has it: mm, degrees about the machine's x, then y, then z. */
export interface Placement {
  origin: [number, number, number];
  rotation: [number, number, number];
}

/** Steps of dragging: mm, degrees. */
const STEP = { length: 0.1, angle: 0.5 };

/** Digits behind these are those of the arithmetic. */
const rounded = (value: number) => Math.round(1e4 * value) / 1e4 + 0;

export class PartFrame {
  readonly group = new Group();
  private readonly handle = new Object3D();
  private readonly controls: TransformControls;
  /** What was set: dragging along axes leaves the angles as they are typed, and the other way round. */
  private placed: Placement = { origin: [0, 0, 0], rotation: [0, 0, 0] };

  constructor(
    camera: Camera,
    element: HTMLElement,
    orbit: { enabled: boolean },
    onChange: (at: { placement: Placement; isDone: boolean }) => void,
  ) {
    // Fixed axes x, y, z are moving axes z, y, x.
    this.handle.rotation.order = "ZYX";
    this.controls = new TransformControls(camera, element);
    this.controls.attach(this.handle);
    this.controls.setSpace("world");
    this.controls.setTranslationSnap(STEP.length);
    this.controls.setRotationSnap(MathUtils.degToRad(STEP.angle));
    this.controls.size = 0.9;
    this.controls.addEventListener("dragging-changed", ({ value }) => {
      // The view holds still while the frame moves.
      orbit.enabled = !value;
      if (value) return;
      this.placed = this.placement;
      onChange({ placement: this.placed, isDone: true });
    });
    this.controls.addEventListener("change", () => onChange({ placement: this.placement, isDone: false }));
    this.group.add(this.handle, this.controls.getHelper());
  }

  /** True while a handle is dragged, or the pointer is over one. */
  get isHeld(): boolean {
    return this.controls.dragging || this.controls.axis !== null;
  }

  get matrix(): Matrix4 {
    this.handle.updateMatrix();
    return this.handle.matrix;
  }

  get placement(): Placement {
    if (this.controls.mode === "rotate") {
      const { x, y, z } = new Euler().setFromQuaternion(this.handle.quaternion, "ZYX");
      const rotation = [x, y, z].map((angle) => rounded(MathUtils.radToDeg(angle))) as Placement["rotation"];
      return { ...this.placed, rotation };
    }
    const origin = this.handle.position.toArray().map(rounded) as Placement["origin"];
    return { ...this.placed, origin };
  }

  set(placement: Placement): void {
    const { origin, rotation } = (this.placed = placement);
    this.handle.position.fromArray(origin);
    const [x, y, z] = rotation.map(MathUtils.degToRad) as Placement["rotation"];
    this.handle.rotation.set(x, y, z, "ZYX");
  }

  setMode(mode: "translate" | "rotate"): void {
    this.controls.setMode(mode);
  }

  dispose(): void {
    this.controls.detach();
    this.controls.dispose();
  }
}
