// Marks that the colours of both scans show, in pairs: proposed, until a person accepts or dismisses them.
import type { ProposedMark, Vector } from "../../api/types";
import type { FitSlice } from "../../fit/state";
import { mayShowInk } from "../../scan/fineColours";
import type { ScanSlice } from "../../scan/state";
import { scannedOther, type StancesSlice } from "../state";

interface OfPair {
  readonly scans: readonly [string, string]; // whose places `source` and `target` are
}

export type Found = OfPair & ({ readonly state: "looking" } | { readonly state: "failed"; readonly reason: string } | { readonly state: "found"; readonly says: string; readonly marks: readonly ProposedMark[] });

export interface FoundSlice {
  readonly found: Found | null;
}

export const initialFound: FoundSlice = { found: null };

type Shown = ScanSlice & FitSlice & StancesSlice;

/** The scans on the page that marks can be looked for between; null without two that are fitted. */
export function pairOf({ scan, fit, stances }: Pick<Shown, "scan" | "fit" | "stances">) {
  const other = scannedOther(stances);
  if (!scan || !other?.scan || fit?.state !== "done" || other.fit?.state !== "done") return null;
  return { scans: [scan.info.id, other.scan.info.id] as const, fits: [fit.id, other.fit.id] as const, haveColours: mayShowInk(scan.info) && mayShowInk(other.scan.info) };
}

/** What was found between these scans, in either order. */
export const foundOn = (found: Found | null, scans: readonly string[] | undefined): Found | null => (found && scans && found.scans.every((scan) => scans.includes(scan)) ? found : null);

/** mm, on this scan, by name. */
export function placesOn(found: Found | null, scan: string | undefined): readonly (readonly [string, Vector])[] {
  if (found?.state !== "found" || scan === undefined || !found.scans.includes(scan)) return [];
  return found.marks.map((mark) => [mark.name, scan === found.scans[0] ? mark.source : mark.target]);
}
