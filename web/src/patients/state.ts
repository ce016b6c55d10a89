// The patients to work through, under codes, as the service pages them.
import type { Patient } from "../api/types";
import { inStance } from "../scan/text";
import * as text from "./text";

export type Order = "newest" | "code" | "deletion";

export interface PatientsState {
  readonly rows: readonly Patient[]; // in the order that the service gives
  readonly next: string | null; // address of the next page
  readonly search: string;
  readonly order: Order;
  readonly isBusy: boolean;
  readonly isKnown: boolean; // the list was read once
  readonly points: Readonly<Record<string, number>>; // by fit: how many are worth checking, where that was asked
  readonly going: readonly string[]; // that will be deleted unless the person takes it back
}

export interface PatientsSlice {
  readonly patients: PatientsState;
}

export const initialPatients: PatientsState = { rows: [], next: null, search: "", order: "newest", isBusy: false, isKnown: false, points: {}, going: [] };

/** The time when the patient's first scan is deleted by age; null: never. */
export function deletedAt({ scans }: Pick<Patient, "scans">): string | null {
  const days = scans.map(({ delete_at }) => delete_at).filter((each) => each !== null).sort();
  return days[0] ?? null;
}

/** Whole days from now, none of them negative. */
export const daysUntil = (at: string, now: Date): number => Math.max(0, Math.floor((new Date(at).getTime() - now.getTime()) / 86_400_000));

const PLACES = ["standing", "supine", "prone"];
const MOST = 4; // pictures on a card

/** Of the newest days, in the strip's order. */
export function latestScans({ scans }: Pick<Patient, "scans">): Patient["scans"] {
  const placeOf = ({ kind, stance }: Patient["scans"][number]): number => (kind === "image" ? PLACES.length : PLACES.indexOf(stance));
  const dayOf = ({ created_at }: Patient["scans"][number]): string => new Date(created_at).toDateString();
  return [...scans].sort((a, b) => (dayOf(a) === dayOf(b) ? placeOf(a) - placeOf(b) : b.created_at.localeCompare(a.created_at))).slice(0, MOST);
}

/** "Wise pattern, 2 lesions" */
export function plannedLine({ planned }: Pick<Patient, "planned">, patterns: readonly { readonly name: string; readonly label: string }[]): string {
  const named = planned.patterns.map((name) => patterns.find((each) => each.name === name)?.label ?? name);
  const said = [...named, ...(planned.lines > 0 ? [text.home.lines(planned.lines)] : []), ...(planned.lesions > 0 ? [text.home.lesions(planned.lesions)] : [])];
  return said.length === 0 ? text.home.nothing : said.join(", ");
}

/** The least sure of the patient's scans: its line error and what is to be done about it; `fit`: that may have points to check. */
export function sureness({ scans }: Pick<Patient, "scans">, points: PatientsState["points"] = {}): { readonly mm: number | null; readonly isKnown: boolean; readonly says: string; readonly fit: string | null } {
  const fits = scans.flatMap(({ fit, stance, kind }) => (fit?.state === "done" ? [{ ...fit, on: kind === "image" ? text.home.onImage : inStance(stance) }] : []));
  const running = scans.some(({ fit }) => fit?.state === "queued" || fit?.state === "running");
  if (fits.length === 0) return { mm: null, isKnown: false, fit: null, says: running ? text.home.fitting : text.home.notFitted };
  const [worst] = [...fits].sort((a, b) => (b.line_error_mm ?? Infinity) - (a.line_error_mm ?? Infinity));
  const bad = fits.find(({ verdict }) => verdict === "unusable") ?? fits.find(({ verdict }) => verdict === "check");
  const says = bad === undefined ? text.home.ready : bad.verdict === "unusable" ? text.home.unusable(bad.on) : text.home.check(points[bad.id], bad.on);
  return { mm: (bad ?? worst)!.line_error_mm, isKnown: bad?.verdict !== "unusable", says, fit: bad?.verdict === "check" ? bad.id : null };
}
