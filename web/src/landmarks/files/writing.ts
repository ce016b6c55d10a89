// Landmark files as they are written: the program's JSON, plain CSV (name,x,y,z), MeshLab's picked points (.pp) and 3D
// Slicer's markups (.mrk.json).  Those of other programs are in the scan's unit, as the service reads them.
import type { LandmarkFile, Unit } from "../../api/types";
import { toUnit } from "../../ui/units";
import type { Picks } from "../picks";

export const ESCAPES: Record<string, string> = { "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" };
const escape = (text: string): string => text.replace(/[&<>"]/g, (sign) => ESCAPES[sign]!);

/** `_scanUnit` is not asked: this kind says its own. */
export function toJson(picks: Picks, _scanUnit: Unit, certain: readonly string[], confidence: Readonly<Record<string, number>> = {}): string {
  const file: LandmarkFile = { schema: "breastrig/landmarks@1", unit: "mm", landmarks: { ...picks }, ...(certain.length > 0 ? { certain: [...certain] } : {}), ...(Object.keys(confidence).length > 0 ? { confidence: { ...confidence } } : {}) };
  return JSON.stringify(file, null, 1) + "\n";
}

/** CSV names no unit, so its numbers are in the scan's unit, as the command line reads them. */
export function toCsv(picks: Picks, scanUnit: Unit): string {
  const rows = Object.entries(picks).map(([name, point]) =>
    [name, ...point.map((mm) => Number(toUnit(mm, scanUnit).toPrecision(8)))].join(","),
  );
  return ["name,x,y,z", ...rows].join("\n") + "\n";
}

export function toMeshlab(picks: Picks, scanUnit: Unit): string {
  const number = (mm: number): string => String(Number(toUnit(mm, scanUnit).toPrecision(8)));
  const points = Object.entries(picks).map(([name, [x, y, z]]) => ` <point x="${number(x)}" y="${number(y)}" z="${number(z)}" active="1" name="${escape(name)}"/>`);
  return ["<!DOCTYPE PickedPoints>", "<PickedPoints>", ...points, "</PickedPoints>", ""].join("\n");
}

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
