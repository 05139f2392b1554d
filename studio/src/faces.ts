// The faces of a part in the picture: their edges, those that are picked, and the one under the pointer.

import { BufferAttribute, BufferGeometry, Group, LineBasicMaterial, LineSegments, Mesh, MeshStandardMaterial, DoubleSide } from "three";
import type { FaceInfo, PartFaces } from "./messages";

export class FacePainter {
  readonly group = new Group();
  private readonly picked: Mesh;
  private readonly hovered: Mesh;
  private under: FaceInfo | null = null;

  constructor(private readonly part: PartFaces, positions: BufferAttribute, normals: BufferAttribute) {
    const overlay = (colour: string, nearer: number) => {
      const geometry = new BufferGeometry();
      geometry.setAttribute("position", positions);
      geometry.setAttribute("normal", normals);
      geometry.setIndex(new BufferAttribute(new Uint32Array(), 1));
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
    if (face === this.under) return;
    this.under = face;
    this.paint(this.hovered, face ? [face] : []);
  }

  private paint(mesh: Mesh, faces: FaceInfo[]): void {
    const indices = new Uint32Array(faces.reduce((sum, { triangles: [, count] }) => sum + 3 * count, 0));
    let to = 0;
    for (const { triangles: [first, count] } of faces) {
      indices.set(this.part.triangles.subarray(3 * first, 3 * (first + count)), to);
      to += 3 * count;
    }
    mesh.geometry.setIndex(new BufferAttribute(indices, 1));
    mesh.visible = to > 0;
  }
}

/** What hovering tells of a face. */
export function wordsOfFace({ number, kind, area, concave_radius }: FaceInfo): string {
  const hollow = concave_radius === null ? "nowhere concave" : `tightest hollow ${concave_radius.toPrecision(3)} mm`;
  return `face ${number}: ${kind}, ${area.toPrecision(4)} mm², ${hollow}`;
}
