// The faces of a part in the picture: their edges, those that are picked, and the one under the pointer.

import { BufferAttribute, BufferGeometry, Group, LineBasicMaterial, LineSegments, Mesh, MeshStandardMaterial, DoubleSide } from "three";
import type { FaceInfo, PartFaces } from "./messages";
import type { Drawing } from "./report";

/** A part that nothing was measured on yet, as the stage draws it. */
export function drawingOfPart({ positions, triangles }: PartFaces): Drawing {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  positions.forEach((value, at) => {
    low[at % 3] = Math.min(low[at % 3]!, value);
    high[at % 3] = Math.max(high[at % 3]!, value);
  });
  const count = positions.length / 3;
  // Past the last measured vertex there is no deviation.
  const surface = { low, high, positions, triangles, deviation: new Int16Array(), step: 0, measured: 0, count };
  const path = { points: new Float32Array(), pieces: [], count: 0, contacts: false };
  // One tool without an outline: nothing is drawn of it.
  return { budget: { total: 0, gouge: 0 }, surface, path, tools: [[]], fixtures: null, check: { method: "", places: [] } };
}

export class FacePainter {
  readonly group = new Group();
  private readonly picked: Mesh;
  private readonly hovered: Mesh;

  constructor(private readonly part: PartFaces, positions: BufferAttribute, normals: BufferAttribute) {
    const overlay = (colour: string, nearer: number) => {
      const geometry = new BufferGeometry();
      geometry.setAttribute("position", positions);
      geometry.setAttribute("normal", normals);
      geometry.setIndex([]);
      const material = new MeshStandardMaterial({ color: colour, side: DoubleSide, roughness: 0.75, polygonOffset: true });
      material.polygonOffsetFactor = material.polygonOffsetUnits = -nearer;
      return new Mesh(geometry, material);
    };
    this.picked = overlay("#3b8fd1", 0.5);
    this.hovered = overlay("#e69f00", 1);
    const edges = new BufferGeometry();
    edges.setAttribute("position", new BufferAttribute(part.edges, 3));
    this.group.add(this.picked, this.hovered, new LineSegments(edges, new LineBasicMaterial({ color: "#16202b" })));
  }

  /** Face of a triangle of the part. */
  faceOf(triangle: number): FaceInfo | null {
    return this.part.faces.find(({ triangles: [first, count] }) => triangle >= first && triangle < first + count) ?? null;
  }

  pick(numbers: number[]): void {
    this.paint(this.picked, this.part.faces.filter(({ number }) => numbers.includes(number)));
  }

  hover(face: FaceInfo | null): void {
    this.paint(this.hovered, face ? [face] : []);
  }

  private paint(mesh: Mesh, faces: FaceInfo[]): void {
    const indices = faces.flatMap(({ triangles: [first, count] }) => [...this.part.triangles.subarray(3 * first, 3 * (first + count))]);
    mesh.geometry.setIndex(indices);
    mesh.visible = indices.length > 0;
  }
}

/** What hovering tells of a face. */
export function wordsOfFace({ number, kind, area, concave_radius }: FaceInfo): string {
  const hollow = concave_radius === null ? "nowhere concave" : `tightest hollow ${concave_radius.toPrecision(3)} mm`;
  return `face ${number}: ${kind}, ${area.toPrecision(4)} mm², ${hollow}`;
}
