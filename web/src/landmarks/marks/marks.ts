// Marks of the patient's skin: moles, dots, ends of pen lines.  The same name on two scans is the same place of the skin.
import type { Vector } from "../../api/types";
import { isMark, markKey, type Picks } from "../picks";

/** Marks of the patient's other scan, and where this one is thought to have them (mm); null where nothing says it. */
export type Beside = Readonly<Record<string, Vector | null>>;

export interface MarksSlice {
  readonly beside: Beside;
}

/** What is asked about the marks of a scan: by its fit, and by the plan that is carried between it and another. */
export interface AskedOfMarks {
  readonly fit: { readonly result: { readonly marks_asked?: readonly { readonly names: readonly string[]; readonly reason: string }[] } | null } | null;
  readonly drawn: { readonly onScan: { readonly plan: { readonly marks?: readonly { readonly asked: readonly { readonly name: string; readonly says: string }[] }[] } } | null };
}

/** Sentences, by a mark's name in the picks. */
export function askedOfMarks({ fit, drawn }: AskedOfMarks, picks: Picks): ReadonlyMap<string, string> {
  const ofFit = (fit?.result?.marks_asked ?? []).flatMap(({ names, reason }) => names.map((name) => [markKey(name), reason] as const));
  const between = (drawn.onScan?.plan.marks ?? []).flatMap(({ asked }) => asked.map(({ name, says }) => [markKey(name), says] as const));
  return new Map([...between, ...ofFit].filter(([name]) => name in picks));
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
