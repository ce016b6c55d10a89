// Picked landmarks: which one is next, and which look wrong.  Points are millimetres in the scan's own axes.
import type { Frame, LandmarkDefinition, Vector } from "../api/types";
import { dot, leftOf } from "./frame";

export type Picks = Readonly<Record<string, Vector>>;
export type Side = "left" | "right" | "middle";

/** Three points fix position, direction and size; with fewer the fit has to find its start in the scan alone. */
export const ENOUGH = 3;

export function sideOf(name: string): Side {
  return name.endsWith("_L") ? "left" : name.endsWith("_R") ? "right" : "middle";
}

export const withPick = (picks: Picks, name: string, point: Vector): Picks => ({ ...picks, [name]: point });

export function withoutPick(picks: Picks, name: string): Picks {
  const { [name]: _dropped, ...rest } = picks;
  return rest;
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

const CLEAR_MM = 15; // the midline wanders this far on a real body before a side is in doubt

/** Names of landmarks that lie on the other side of the body than their name says. */
export function onWrongSide(picks: Picks, frame: Frame): ReadonlySet<string> {
  const axis = leftOf(frame);
  const across = Object.entries(picks).map(([name, point]) => ({ name, side: sideOf(name), x: dot(point, axis) }));
  const middle = across.filter((entry) => entry.side === "middle");
  const wrong = new Set<string>();
  for (const entry of across) {
    if (entry.side === "middle") continue;
    const sign = entry.side === "left" ? 1 : -1;
    const partner = across.find((other) => other.name === entry.name.slice(0, -1) + (sign > 0 ? "R" : "L"));
    const limit = middle.length > 0 ? middle.reduce((sum, each) => sum + each.x, 0) / middle.length : partner?.x;
    if (limit !== undefined && sign * (entry.x - limit) < (middle.length > 0 ? -CLEAR_MM : 0)) wrong.add(entry.name);
  }
  return wrong;
}
