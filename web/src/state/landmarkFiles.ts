// Landmark files in and out: the program's JSON and plain CSV (name,x,y,z), read and written on this machine.
import type { LandmarkDefinition, LandmarkFile, Unit, Vector } from "../api/types";
import { isUnit, mmFrom, toUnit } from "../units";
import type { Picks } from "./landmarks";

export class UnreadableLandmarks extends Error {}

export function toJson(picks: Picks): string {
  const file: LandmarkFile = { schema: "breastrig/landmarks@1", unit: "mm", landmarks: { ...picks } };
  return JSON.stringify(file, null, 1) + "\n";
}

/** CSV names no unit, so its numbers are in the scan's unit, as the command line reads them. */
export function toCsv(picks: Picks, scanUnit: Unit): string {
  const rows = Object.entries(picks).map(([name, point]) =>
    [name, ...point.map((mm) => Number(toUnit(mm, scanUnit).toPrecision(8)))].join(","),
  );
  return ["name,x,y,z", ...rows].join("\n") + "\n";
}

function checked(name: string, coordinates: unknown[], unit: Unit, known: ReadonlySet<string>): Vector {
  if (!known.has(name)) {
    throw new UnreadableLandmarks(`“${name}” is not a landmark of this model: rename or remove it in the file.`);
  }
  const numbers = coordinates.map((cell) => (typeof cell === "string" && cell !== "" ? Number(cell) : cell)) as number[];
  if (numbers.length !== 3 || !numbers.every(Number.isFinite)) {
    throw new UnreadableLandmarks(`The landmark “${name}” needs three numbers, x, y and z.`);
  }
  return numbers.map((value) => mmFrom(value, unit)) as Vector;
}

function fromJson(text: string, scanUnit: Unit, known: ReadonlySet<string>): Picks {
  let file: Partial<LandmarkFile>;
  try {
    file = JSON.parse(text) as Partial<LandmarkFile>;
  } catch {
    throw new UnreadableLandmarks("The file is not valid JSON: export the landmarks again.");
  }
  const unit = file.unit ?? scanUnit;
  if (!isUnit(unit)) throw new UnreadableLandmarks(`The unit “${String(unit)}” is not known: use m, dm, cm, mm or in.`);
  if (typeof file.landmarks !== "object" || file.landmarks === null) {
    throw new UnreadableLandmarks("The file holds no “landmarks”: choose a BreastRig landmark file.");
  }
  const entries = Object.entries(file.landmarks);
  return Object.fromEntries(
    entries.map(([name, point]) => [name, checked(name, Array.isArray(point) ? point : [], unit, known)]),
  );
}

function fromCsv(text: string, scanUnit: Unit, known: ReadonlySet<string>): Picks {
  const rows = text.split(/\r?\n/).map((line) => line.split(/[,;\t]/).map((cell) => cell.trim()));
  const filled = rows.filter((cells) => cells.some((cell) => cell !== "") && !cells[0]?.startsWith("#"));
  const body = filled[0]?.[0]?.toLowerCase() === "name" ? filled.slice(1) : filled;
  return Object.fromEntries(
    body.map(([name = "", ...cells]) => [name, checked(name, cells, scanUnit, known)]),
  );
}

/** Reads JSON or CSV; throws UnreadableLandmarks with one plain sentence. */
export function readLandmarks(text: string, scanUnit: Unit, list: readonly LandmarkDefinition[]): Picks {
  const known = new Set(list.map((entry) => entry.name));
  const picks = text.trimStart().startsWith("{") ? fromJson(text, scanUnit, known) : fromCsv(text, scanUnit, known);
  if (Object.keys(picks).length === 0) throw new UnreadableLandmarks("The file holds no landmarks.");
  return picks;
}
