// The own drawing as breastrig/drawing@1: what the service keeps, and what is read and written as a file here.
import type { OwnDrawing, Unit, Vector } from "../../api/types";
import { word } from "../../languages/words";
import { isUnit, mmFrom, unknownUnit } from "../../ui/units";
import { lineAlong } from "./edits";
import { freeName, INK, type OwnLine } from "./lines";

export class UnreadableDrawing extends Error {}

const LONGEST_NAME = 100;
export const roundMm = (mm: number): number => Number(mm.toFixed(3)); // a micrometre: two hundred lines fit into what the service takes

/** By which a file says whose it is: the patient's code, and the hashes of the scans that it was made on. */
export interface Whose {
  readonly patient: string | null;
  readonly scans: readonly string[];
}

export function toDrawing(lines: readonly OwnLine[], whose: Whose | null = null): OwnDrawing {
  return {
    schema: "breastrig/drawing@1",
    unit: "mm",
    ...(whose?.patient ? { patient: whose.patient } : {}),
    ...(whose?.scans[0] ? { scan_sha256: whose.scans[0] } : {}),
    shapes: lines.map(({ name, closed, color, points, bridged }) => ({ name, label: "", closed, color, points: points.map((point) => point.map(roundMm) as Vector), ...(bridged ? { bridged: [...bridged] } : {}) })),
  };
}

export const toText = (lines: readonly OwnLine[], whose: Whose | null = null): string => JSON.stringify(toDrawing(lines, whose), null, 1) + "\n";

/** What a drawing or plan file says of whose it is; nothing where it is no such file. */
export function whoseIs(text: string): Whose {
  const said = (value: unknown): string | null => (typeof value === "string" && value !== "" ? value : null);
  try {
    const file = JSON.parse(text) as { patient?: unknown; scan_sha256?: unknown; scans?: unknown } | null;
    const listed = Array.isArray(file?.scans) ? (file.scans as ({ sha256?: unknown } | null)[]).map((scan) => scan?.sha256) : [];
    return { patient: said(file?.patient), scans: [file?.scan_sha256, ...listed].map(said).filter((each) => each !== null) };
  } catch {
    return { patient: null, scans: [] };
  }
}

/** Whether the file names somebody, and neither this patient nor this scan. */
export const isAnothers = (file: Whose, patient: string, scan: string): boolean => (file.patient !== null || file.scans.length > 0) && file.patient !== patient && !file.scans.includes(scan);

function checkedPoint(point: unknown, name: string, unit: Unit): Vector {
  const numbers = Array.isArray(point) ? point : [];
  if (numbers.length !== 3 || !numbers.every((value) => typeof value === "number" && Number.isFinite(value))) {
    throw new UnreadableDrawing(word("drawing.unreadable.point", { name }));
  }
  return numbers.map((value: number) => mmFrom(value, unit)) as Vector;
}

/** Lines of a drawing file, in millimetres; throws UnreadableDrawing with one plain sentence. */
export function readDrawing(text: string, scanUnit: Unit): OwnLine[] {
  let file: { unit?: unknown; shapes?: unknown } | null;
  try {
    file = JSON.parse(text) as typeof file;
  } catch {
    throw new UnreadableDrawing(word("drawing.unreadable.json"));
  }
  const unit = file?.unit ?? scanUnit;
  if (!isUnit(unit)) throw new UnreadableDrawing(unknownUnit(unit));
  if (!Array.isArray(file?.shapes)) throw new UnreadableDrawing(word("drawing.unreadable.shapes"));
  const lines: OwnLine[] = [];
  for (const shape of file.shapes as Record<string, unknown>[]) {
    const name = typeof shape.name === "string" && shape.name.trim() !== "" ? shape.name.trim().slice(0, LONGEST_NAME) : word("drawing.stem");
    if (!Array.isArray(shape.points)) {
      throw new UnreadableDrawing(word("drawing.unreadable.points", { name }));
    }
    const points = shape.points.map((point) => checkedPoint(point, name, unit));
    const color = typeof shape.color === "string" && /^#[0-9a-fA-F]{6}$/.test(shape.color) ? shape.color : INK;
    if (points.length > 1) lines.push(lineAlong(freeName(lines, name), color, points, shape.closed === true, Array.isArray(shape.bridged) ? shape.bridged.map((each) => each === true) : null));
  }
  if (lines.length === 0) throw new UnreadableDrawing(word("drawing.unreadable.none"));
  return lines;
}
