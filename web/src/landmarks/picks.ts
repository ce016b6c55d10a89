// Picked landmarks: which one is next, and which look wrong.  Points are millimetres in the scan's own axes.
import type { Frame, LandmarkDefinition, LandmarkFile, Vector } from "../api/types";
import { isUnit, mmFrom } from "../ui/units";
import { cross, dot, leftOf, tidyFrame } from "../viewer/frame";

export type Picks = Readonly<Record<string, Vector>>;
export type Side = "left" | "right" | "middle";

/** Three points fix position, direction and size; with fewer the fit has to find its start in the scan alone. */
export const ENOUGH = 3;

// Marks of the patient's skin (moles, dots) are picks, too, under their own name behind this: no landmark's begins so.
const MARK = "mark:";
export const isMark = (name: string): boolean => name.startsWith(MARK);
export const markKey = (called: string): string => MARK + called;
export const markCalled = (name: string): string => name.slice(MARK.length);

/** As files and fits have them. */
export function placesOf(picks: Picks): Required<Pick<LandmarkFile, "landmarks" | "marks">> {
  const entries = Object.entries(picks);
  return {
    landmarks: Object.fromEntries(entries.filter(([name]) => !isMark(name))),
    marks: Object.fromEntries(entries.filter(([name]) => isMark(name)).map(([name, point]) => [markCalled(name), point])),
  };
}

export function sideOf(name: string): Side {
  if (isMark(name)) return "middle";
  return name.endsWith("_L") ? "left" : name.endsWith("_R") ? "right" : "middle";
}

const SIDE = /[\s,(]*\b(?:(?:the\s+)?(?:patient['’]s\s+)?(?:left|right)(?:\s+side)?|(?:Patient\s+)?(?:links|rechts|(?:linke|rechte)[mnrs]?))\b\)?/i; // as the service says it in each language

/** The label without its side, which a mark beside it says louder. */
export function plainLabel(label: string): string {
  const plain = label.replace(SIDE, "").trim();
  return plain === "" ? label : plain.charAt(0).toUpperCase() + plain.slice(1);
}

/** A landmark file's points and marks in millimetres. */
export function picksOf(file: { landmarks: LandmarkFile["landmarks"]; marks?: LandmarkFile["marks"]; unit?: string }): Picks {
  const unit = isUnit(file.unit) ? file.unit : "mm";
  const entries = [...Object.entries(file.landmarks), ...Object.entries(file.marks ?? {}).map(([name, point]) => [markKey(name), point] as const)];
  return Object.fromEntries(entries.map(([name, point]) => [name, point.map((value) => mmFrom(value, unit)) as Vector]));
}

/** Under another name, where it stood among the others. */
export const renamed = (picks: Picks, from: string, to: string): Picks => Object.fromEntries(Object.entries(picks).map(([name, place]) => [name === from ? to : name, place]));

export const withPick = (picks: Picks, name: string, point: Vector): Picks => ({ ...picks, [name]: point });

export function withoutPick(picks: Picks, name: string): Picks {
  const { [name]: _dropped, ...rest } = picks;
  return rest;
}

/** What a step of the history has changed, by name. */
/** Of files of landmarks that the service reads. */
export const LANDMARK_ENDINGS: readonly string[] = [".json", ".csv", ".tsv", ".txt", ".pp", ".fcsv", ".pts", ".lmk"];

export const picksChanged = (before: Picks, after: Picks): { placed: string[]; moved: string[]; removed: string[] } => ({
  placed: Object.keys(after).filter((name) => !(name in before)),
  moved: Object.keys(after).filter((name) => name in before && before[name]!.some((value, axis) => value !== after[name]![axis])),
  removed: Object.keys(before).filter((name) => !(name in after)),
});

/** The picks of these landmarks with their places exchanged: two with each other, more each with its partner. */
export function exchanged(picks: Picks, names: readonly string[]): Picks {
  const [first, second] = names;
  const goal = (name: string): string => {
    if (!names.includes(name)) return name;
    if (names.length === 2) return name === first ? second! : first!;
    return sideOf(name) === "middle" ? name : partnerOf(name);
  };
  return Object.fromEntries(Object.entries(picks).map(([name, place]) => [goal(name), place]));
}

/** The first landmark after `from`, in the list's order and round its end, that is neither placed nor skipped. */
export function nextMissing(
  list: readonly LandmarkDefinition[],
  picks: Picks,
  skipped: ReadonlySet<string>,
  from: string | null = null,
): string | null {
  const start = from === null ? 0 : list.findIndex((entry) => entry.name === from) + 1;
  const inOrder = [...list.slice(start), ...list.slice(0, start)];
  return inOrder.find((entry) => !(entry.name in picks) && !skipped.has(entry.name))?.name ?? null;
}

export const partnerOf = (name: string): string => name.slice(0, -1) + (name.endsWith("_L") ? "R" : "L");

/** Left landmarks with a partner, and the way from right to left between the two (mm). */
function acrossPairs(picks: Picks): { name: string; across: Vector }[] {
  return Object.entries(picks).flatMap(([name, left]) => {
    const right = sideOf(name) === "left" ? picks[partnerOf(name)] : undefined;
    return right ? [{ name, across: left.map((value, axis) => value - right[axis]!) as Vector }] : [];
  });
}

/** Names of landmarks that lie the wrong way round: the patient's left on the right of its partner. */
export function onWrongSide(picks: Picks, frame: Frame): ReadonlySet<string> {
  const axis = leftOf(frame);
  const swapped = acrossPairs(picks).filter(({ across }) => dot(across, axis) < 0);
  return new Set(swapped.flatMap(({ name }) => [name, partnerOf(name)]));
}

const APART_MM = 60; // along the midline; closer points say too little about a direction
const LOW_TO_HIGH = ["umbilicus", "xiphoid", "mid_sternum", "suprasternal_notch"];
// The skin of the midline is no plumb line: on the model at rest, which stands upright, these points lie so high and so
// far to the front (mm).  Taken for upright, the way from navel to notch would lean a body back by eleven degrees.
const AT_REST: Readonly<Record<string, readonly [high: number, front: number]>> = { umbilicus: [158.0, 137.3], xiphoid: [279.2, 143.0], mid_sternum: [392.1, 125.1], suprasternal_notch: [489.9, 72.1] };

/** Radians by which the skin between two points of the midline leans back on an upright body. */
function leanAtRest(low: string, high: string): number {
  const [from, to] = [AT_REST[low]!, AT_REST[high]!];
  return Math.atan2(from[1] - to[1], to[0] - from[0]);
}

const turnedForward = (up: Vector, front: Vector, angle: number): Frame => {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  const mixed = (a: Vector, b: Vector, share: number): Vector => [c * a[0] + share * b[0], c * a[1] + share * b[1], c * a[2] + share * b[2]];
  return { up: mixed(up, front, s), front: mixed(front, up, -s) };
};

/** How the body stands by its landmarks, to a few degrees.  Null while they say too little. */
export function frameFromPicks(picks: Picks): Frame | null {
  const left: Vector = [0, 0, 0];
  for (const { across } of acrossPairs(picks)) across.forEach((value, axis) => (left[axis]! += value));
  const known = LOW_TO_HIGH.filter((name) => name in picks);
  const [low, high] = [known[0], known.at(-1)];
  if (low === undefined || high === undefined) return null;
  const up = picks[high]!.map((value, axis) => value - picks[low]![axis]!) as Vector;
  const front = cross(left, up);
  const isClear = Math.hypot(...up) > APART_MM && Math.hypot(...left) > APART_MM && Math.hypot(...front) > APART_MM ** 2;
  if (!isClear) return null;
  const skin = tidyFrame({ up: cross(front, left), front });
  return tidyFrame(turnedForward(skin.up, skin.front, leanAtRest(low, high)));
}
