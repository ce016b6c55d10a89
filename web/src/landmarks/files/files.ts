// Landmark files as they are read, on this machine: the program's JSON, plain CSV (name,x,y,z) and what MeshLab and 3D
// Slicer write.  Loaded when somebody opens one.
import type { LandmarkDefinition, LandmarkFile, Unit, Vector } from "../../api/types";
import { isUnit, mmFrom, unknownUnit } from "../../ui/units";
import { fromMeshlab, fromSlicer, type NamedCells } from "./otherFormats";
import type { Picks } from "../picks";
import { UnreadableLandmarks } from "./unreadable";

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

function gathered(pairs: NamedCells, unit: Unit, known: ReadonlySet<string>): Picks {
  return Object.fromEntries(pairs.map(([name, cells]) => [name, checked(name, cells, unit, known)]));
}

function fromJson(text: string, scanUnit: Unit, known: ReadonlySet<string>): Picks {
  let file: Partial<Record<keyof LandmarkFile | "markups", unknown>>;
  try {
    file = JSON.parse(text) as typeof file;
  } catch {
    throw new UnreadableLandmarks("The file is not valid JSON: export the landmarks again.");
  }
  if ("markups" in file) {
    const pairs = fromSlicer(file.markups);
    if (!pairs) throw new UnreadableLandmarks("This 3D Slicer file is incomplete or in neither LPS nor RAS: save the point list again.");
    return gathered(pairs, scanUnit, known);
  }
  const unit = file.unit ?? scanUnit;
  if (!isUnit(unit)) throw new UnreadableLandmarks(unknownUnit(unit));
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

function fromXml(text: string, scanUnit: Unit, known: ReadonlySet<string>): Picks {
  const pairs = fromMeshlab(text);
  if (!pairs) throw new UnreadableLandmarks("This XML is not a MeshLab file of picked points: choose a .pp file.");
  return gathered(pairs, scanUnit, known);
}

/** Reads JSON, CSV, .pp or .mrk.json, by content and not by name; throws UnreadableLandmarks with one plain sentence. */
export function readLandmarks(text: string, scanUnit: Unit, list: readonly LandmarkDefinition[]): Picks {
  const known = new Set(list.map((entry) => entry.name));
  const start = text.trimStart().charAt(0);
  const read = start === "{" ? fromJson : start === "<" ? fromXml : fromCsv;
  const picks = read(text, scanUnit, known);
  if (Object.keys(picks).length === 0) throw new UnreadableLandmarks("The file holds no landmarks.");
  return picks;
}

/** What a file that readLandmarks has read calls certain; throws UnreadableLandmarks with one plain sentence. */
export function readCertain(text: string, picks: Picks): string[] {
  if (!text.trimStart().startsWith("{")) return [];
  const { certain = [] } = JSON.parse(text) as { certain?: unknown };
  if (!Array.isArray(certain) || !certain.every((name): name is string => typeof name === "string")) {
    throw new UnreadableLandmarks("“certain” in this file must be a list of landmarks' names: mend or remove it.");
  }
  const unknown = certain.find((name) => !Object.hasOwn(picks, name));
  if (unknown !== undefined) throw new UnreadableLandmarks(`“certain” names “${unknown}”, which is not among the file's landmarks: pick it or take it out.`);
  return certain;
}
