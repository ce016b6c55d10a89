// Landmark files of other programs: MeshLab's picked points (.pp) and 3D Slicer's markups (.mrk.json).
// Both show a mesh's numbers as they are, so theirs are in the scan's unit, whatever the file calls it.
import type { Unit, Vector } from "../../api/types";
import { toUnit } from "../../ui/units";
import type { Picks } from "../picks";

export type NamedCells = [name: string, cells: unknown[]][];

const ESCAPES: Record<string, string> = { "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" };
const escape = (text: string): string => text.replace(/[&<>"]/g, (sign) => ESCAPES[sign]!);
const unescape = (text: string): string => Object.entries(ESCAPES).reduceRight((plain, [sign, coded]) => plain.replaceAll(coded, sign), text);

/** A template's points that were not picked are left out; null when it is not such a file. */
export function fromMeshlab(text: string): NamedCells | null {
  if (!/<PickedPoints\b/.test(text)) return null;
  return [...text.matchAll(/<point\b([^>]*)>/g)].flatMap(([, inside]) => {
    const attributes = Object.fromEntries([...inside!.matchAll(/(\w+)\s*=\s*"([^"]*)"/g)].map(([, key, value]) => [key!, unescape(value!)]));
    return attributes.active === "0" ? [] : [[attributes.name ?? "", ["x", "y", "z"].map((axis) => attributes[axis] ?? "")] as [string, unknown[]]];
  });
}

export function toMeshlab(picks: Picks, scanUnit: Unit): string {
  const number = (mm: number): string => String(Number(toUnit(mm, scanUnit).toPrecision(8)));
  const points = Object.entries(picks).map(([name, [x, y, z]]) => ` <point x="${number(x)}" y="${number(y)}" z="${number(z)}" active="1" name="${escape(name)}"/>`);
  return ["<!DOCTYPE PickedPoints>", "<PickedPoints>", ...points, "</PickedPoints>", ""].join("\n");
}

/** Points stored as LPS, Slicer's default, are the mesh file's own numbers; as RAS, x and y have the other sign. */
const SIGNS: Record<string, Vector> = { LPS: [1, 1, 1], "1": [1, 1, 1], RAS: [-1, -1, 1], "0": [-1, -1, 1] };

/** The name of the format's version, by which Slicer knows it; nothing is fetched from there. */
const SLICER_SCHEMA = "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/Resources/Schema/markups-schema-v1.0.3.json#";

export function toSlicer(picks: Picks, scanUnit: Unit): string {
  const controlPoints = Object.entries(picks).map(([label, place], index) => ({
    id: String(index + 1),
    label,
    position: place.map((mm) => Number(toUnit(mm, scanUnit).toPrecision(8))),
    positionStatus: "defined",
  }));
  const markups = [{ type: "Fiducial", coordinateSystem: "LPS", coordinateUnits: "mm", controlPoints }];
  return `${JSON.stringify({ "@schema": SLICER_SCHEMA, markups }, null, 1)}\n`;
}

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
