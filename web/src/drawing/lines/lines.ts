// The surgeon's own lines as plain values.  Each point lies on the scan's skin, about two millimetres from the next;
// some of them are corners, which a person may move.  Points are millimetres in the scan's own axes.
import type { DrawnShape, Vector } from "../../api/types";
import { metresFromMm } from "../../ui/units";
import type { Polyline } from "../../viewer/lines/FatLines";

/** The service's polyline with all that it may leave out, without what a hand cannot know, and with corners. */
export interface OwnLine extends Readonly<Required<Pick<DrawnShape, "name" | "closed" | "color">>> {
  /** in the plan; it stays when the line is renamed or moved; missing until the line is first saved */
  readonly id?: string;
  // the name is unique on the scan: it is what the page knows the line by
  readonly points: readonly Vector[];
  /** per point: ink was not seen there, because the scan has a hole; left out where it was seen all along */
  readonly bridged?: readonly boolean[];
  /** what of the scan's ink it was made from, however it was changed since; the service's names */
  readonly ink?: readonly string[];
  /** it was not drawn by hand but is the other side's line, mirrored, however it was changed since */
  readonly mirrored?: boolean;
  /** mm below the skin, how deep it is to be cut; missing where nobody has said */
  readonly depthMm?: number;
  /** indices into points, rising; an open line has its two ends among them */
  readonly corners: readonly number[];
}

/** Unguessable, and allowed in the plan. */
export const newId = (): string => crypto.randomUUID();

export const INK = "#101010";
export const TUMOUR_INK = "#f3c400"; // as lesions are

/** `wanted`, or `wanted 2`, `wanted 3` … : the first that no other line has. */
export function freeName(lines: readonly OwnLine[], wanted: string): string {
  const taken = new Set(lines.map(({ name }) => name));
  if (!taken.has(wanted)) return wanted;
  let number = 2;
  while (taken.has(`${wanted} ${number}`)) number += 1;
  return `${wanted} ${number}`;
}

/** `Line 1`, `Line 2` …: numbered from the first. */
export function nextName(lines: readonly OwnLine[], stem: string): string {
  const taken = new Set(lines.map(({ name }) => name));
  let number = 1;
  while (taken.has(`${stem} ${number}`)) number += 1;
  return `${stem} ${number}`;
}

/** With what is guessed, where anything is. */
export const guessedAt = <Line extends Pick<OwnLine, "points">>(line: Line, bridged: readonly boolean[] | null | undefined): Line & Pick<OwnLine, "bridged"> =>
  bridged?.length === line.points.length && bridged.includes(true) ? { ...line, bridged } : line;

export const withLine = (lines: readonly OwnLine[], name: string, change: (line: OwnLine) => OwnLine): readonly OwnLine[] =>
  lines.map((line) => (line.name === name ? change(line) : line));

export const withoutLine = (lines: readonly OwnLine[], name: string): readonly OwnLine[] => lines.filter((line) => line.name !== name);

/** What the viewer shows of a polyline whose unit is so many millimetres. */
export function polyline({ points, closed, bridged, color }: Pick<DrawnShape, "closed" | "bridged" | "color"> & { readonly points: readonly Vector[] }, mmPerUnit = 1): Polyline {
  const out = new Float32Array(3 * points.length);
  points.forEach((point, i) => out.set(point.map((value) => metresFromMm(value * mmPerUnit)), 3 * i));
  return { points: out, isClosed: closed ?? false, bridged: bridged ?? null, colour: ownColour(color) };
}

/** The colour that a file gives its line; null where it gives none: then it is the ink of its layer. */
export const ownColour = (color: string | null | undefined): string | null => (color == null || color.toLowerCase() === INK ? null : color);

/** Along the line, millimetres. */
export function lengthOf({ points, closed }: Pick<OwnLine, "points" | "closed">): number {
  let sum = 0;
  for (let i = 1; i < points.length; i += 1) sum += gap(points[i - 1]!, points[i]!);
  return closed && points.length > 1 ? sum + gap(points.at(-1)!, points[0]!) : sum;
}

export const gap = (a: Vector, b: Vector): number => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
