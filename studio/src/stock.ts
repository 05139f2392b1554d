// Stock as it is cut: the bricks of its surface, and the time at which they are.

import { type Box3, BufferAttribute, BufferGeometry, DoubleSide, Group, Mesh, MeshStandardMaterial } from "three";
import type { Bricks, StockCut } from "./messages";
import { PATCHES } from "./renewed";

/** Warm grey of raw material: no deviation, tool or fixture has it. */
const STOCK_COLOUR = "#c8b898";
/** Share of the distance of rays by which the surface is drawn too far away: what is cut to that is the part's, in its colours. */
const BEHIND = 0.35;

/** The surface of the part is drawn farther away by this, so that lines on it are seen: stock as well, or it would hide the part. */
const AS_THE_PART = { polygonOffset: true, polygonOffsetFactor: 1.5, polygonOffsetUnits: 1.5 };

interface Brick {
  number: number;
  positions: Float32Array;
  triangles: Uint32Array;
}

/** Divides the arrays of a change into bricks. */
export function* bricksOf({ counts, positions, triangles }: Bricks): Generator<Brick> {
  let [vertex, triangle] = [0, 0];
  for (let at = 0; at < counts.length; at += 3) {
    const [number, vertices, faces] = counts.subarray(at, at + 3) as unknown as [number, number, number];
    yield {
      number,
      positions: positions.subarray(3 * vertex, 3 * (vertex + vertices)),
      triangles: triangles.subarray(3 * triangle, 3 * (triangle + faces)),
    };
    vertex += vertices;
    triangle += faces;
  }
}

/** Surface of stock in a scene. */
export class StockSurface {
  readonly group = new Group();
  private readonly bricks = new Map<number, Mesh>();
  private readonly material: MeshStandardMaterial;

  /** `cell` is the distance of the rays, mm. */
  constructor(cell: number) {
    this.material = stockMaterial(cell);
  }

  get count(): number {
    return this.bricks.size;
  }

  /** Puts a brick in the place of the one with its number; returns the boxes around both. */
  take({ number, positions, triangles }: Brick): Box3[] {
    const before = this.bricks.get(number);
    const changed = before ? [before.geometry.boundingBox!] : [];
    if (before) {
      this.group.remove(before);
      before.geometry.dispose();
      this.bricks.delete(number);
    }
    if (triangles.length === 0) return changed;
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(positions, 3));
    geometry.setIndex(new BufferAttribute(positions.length / 3 < 65_536 ? new Uint16Array(triangles) : triangles, 1));
    geometry.computeBoundingBox();
    geometry.computeBoundingSphere();
    const mesh = new Mesh(geometry, this.material);
    mesh.matrixAutoUpdate = false;
    mesh.layers.enable(PATCHES);
    this.group.add(mesh);
    this.bricks.set(number, mesh);
    return [...changed, geometry.boundingBox!];
  }

  get meshes(): Mesh[] {
    return [...this.bricks.values()];
  }
}

/** Facets stay facets: edges and marks of the tool are seen as they are. */
export function stockMaterial(cell: number): MeshStandardMaterial {
  const material = new MeshStandardMaterial({ color: STOCK_COLOUR, flatShading: true, roughness: 0.85, metalness: 0, side: DoubleSide, ...AS_THE_PART });
  material.onBeforeCompile = (shader) => {
    shader.uniforms.behind = { value: BEHIND * cell };
    const project = "#include <project_vertex>";
    const farther = "vec4 farther = projectionMatrix * (mvPosition - vec4(0.0, 0.0, behind, 0.0));\n  gl_Position.z = farther.z / farther.w * gl_Position.w;";
    shader.vertexShader = `uniform float behind;\n${shader.vertexShader.replace(project, `${project}\n  ${farther}`)}`;
  };
  return material;
}

/** Milliseconds after which stock that does not come is said to be behind. */
const LATE = 250;

/** Usual milliseconds from one stock that keeps up with the slider to the next. */
const BETWEEN = 100;

const pause = (milliseconds: number) => new Promise((resolve) => setTimeout(resolve, milliseconds));

/** What stock needs and what hears of it. */
export interface StockEnds {
  /** Goes towards a time, s; it may stop before it. */
  cut(time: number): Promise<StockCut>;
  draw(bricks: Bricks): Promise<void>;
  /** Hears whether the stock is still on its way to the time that was asked for. */
  onBehind(isBehind: boolean): void;
  onRefused(error: unknown): void;
}

/** Brings stock to the time that is wanted: asks for one time at a time, the newest, and draws what came before it asks again. */
export class StockFollower {
  private wanted: number | null = null;
  /** Time that was reached last. */
  private shown: number | null = null;
  private isBusy = false;
  private isEnded = false;

  /** `between` is the least time from one stock that keeps up with the slider to the next, ms. */
  constructor(
    private readonly ends: StockEnds,
    private readonly between = BETWEEN,
  ) {}

  /** Wants the stock of a time, s. */
  seek(time: number): void {
    this.wanted = time;
    void this.follow();
  }

  end(): void {
    this.isEnded = true;
  }

  private async follow(): Promise<void> {
    if (this.isBusy) return;
    this.isBusy = true;
    try {
      while (!this.isEnded && this.wanted !== null && this.wanted !== this.shown) {
        const begin = performance.now();
        const isThere = await this.go(this.wanted);
        // Stock that keeps up with the slider leaves the picture at least as much time as it takes.
        if (isThere) await pause(Math.max(this.between, performance.now() - begin));
      }
    } catch (error) {
      // An engine that is ended refuses what it was asked for.
      if (!this.isEnded) this.ends.onRefused(error);
    } finally {
      this.isBusy = false;
    }
  }

  /** Returns true if the time that was asked for is reached. */
  private async go(asked: number): Promise<boolean> {
    const late = setTimeout(() => this.ends.onBehind(true), LATE);
    try {
      const { time, isThere, bricks } = await this.ends.cut(asked);
      if (this.isEnded) return false;
      await this.ends.draw(bricks);
      this.shown = isThere ? asked : time;
      this.ends.onBehind(!isThere);
      return isThere;
    } finally {
      clearTimeout(late);
    }
  }
}
