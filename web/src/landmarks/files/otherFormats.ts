// Landmark files of other programs: MeshLab's picked points (.pp) and 3D Slicer's markups (.mrk.json).
// Both show a mesh's numbers as they are, so theirs are in the scan's unit, whatever the file calls it.
import type { Vector } from "../../api/types";
import { ESCAPES } from "./writing";

export type NamedCells = [name: string, cells: unknown[]][];

const unescape = (text: string): string => Object.entries(ESCAPES).reduceRight((plain, [sign, coded]) => plain.replaceAll(coded, sign), text);

/** A template's points that were not picked are left out; null when it is not such a file. */
export function fromMeshlab(text: string): NamedCells | null {
  if (!/<PickedPoints\b/.test(text)) return null;
  return [...text.matchAll(/<point\b([^>]*)>/g)].flatMap(([, inside]) => {
    const attributes = Object.fromEntries([...inside!.matchAll(/(\w+)\s*=\s*"([^"]*)"/g)].map(([, key, value]) => [key!, unescape(value!)]));
    return attributes.active === "0" ? [] : [[attributes.name ?? "", ["x", "y", "z"].map((axis) => attributes[axis] ?? "")] as [string, unknown[]]];
  });
}

/** Points stored as LPS, Slicer's default, are the mesh file's own numbers; as RAS, x and y have the other sign. */
const SIGNS: Record<string, Vector> = { LPS: [1, 1, 1], "1": [1, 1, 1], RAS: [-1, -1, 1], "0": [-1, -1, 1] };

interface Markup {
  coordinateSystem?: string | number;
  controlPoints?: { label?: string; position?: unknown; positionStatus?: string }[];
}

/** `markups` of such a file; null when it says neither LPS nor RAS, or is incomplete. */
export function fromSlicer(markups: unknown): NamedCells | null {
  if (!Array.isArray(markups)) return null;
  const pairs: NamedCells = [];
  for (const { coordinateSystem, controlPoints } of markups as Markup[]) {
    const signs = SIGNS[String(coordinateSystem ?? "LPS").toUpperCase()];
    if (!signs || !Array.isArray(controlPoints)) return null;
    for (const { label, position, positionStatus } of controlPoints) {
      if ((positionStatus ?? "defined") !== "defined") continue; // not placed, or skipped
      const cells: unknown[] = Array.isArray(position) ? position : [];
      pairs.push([label ?? "", cells.map((value, axis) => (typeof value === "number" ? value * (signs[axis] ?? 1) : value))]);
    }
  }
  return pairs;
}
