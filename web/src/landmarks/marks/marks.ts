// Marks of the patient's skin: moles, dots, ends of pen lines.  The same name on two scans is the same place of the skin.
import type { Vector } from "../../api/types";
import { isMark, markKey, type Picks } from "../picks";

/** Marks of the patient's other scan, and where this one is thought to have them (mm); null where nothing says it. */
export type Beside = Readonly<Record<string, Vector | null>>;

export interface MarksSlice {
  readonly beside: Beside;
}

export const initialMarks: MarksSlice = { beside: {} };

/** "mark 3": the first that nothing is called. */
export function freeMark(taken: readonly string[]): string {
  let number = 1;
  while (taken.includes(markKey(`mark ${number}`))) number += 1;
  return markKey(`mark ${number}`);
}

/** The one to place after this: of the other scan's, in their order and round its end. */
export function nextBeside(beside: Beside, picks: Picks, after: string): string | null {
  const names = Object.keys(beside);
  const start = names.indexOf(after) + 1;
  return [...names.slice(start), ...names.slice(0, start)].find((name) => !(name in picks)) ?? null;
}

/** Those on this scan, and those that only the other one has. */
export const listedMarks = (picks: Picks, beside: Beside): string[] => [...new Set([...Object.keys(picks).filter(isMark), ...Object.keys(beside)])];
