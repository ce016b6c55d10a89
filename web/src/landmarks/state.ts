// Landmarks on the page's scan: placed ones with their history, proposed ones, and the one that the next click places.
import { type History, startHistory } from "../store/history";
import { type Certain, certainAt } from "./certain";
import { isMark, type Picks } from "./picks";
import type { Proposals } from "./proposals/proposals";

export interface LandmarksSlice {
  readonly picks: History<Picks>;
  readonly certain: Certain;
  readonly proposals: Proposals | null; // null until somebody asked
  readonly skipped: ReadonlySet<string>;
  readonly active: string | null; // the landmark or mark that the next click places
  readonly saving: "saved" | "saving" | "unsaved";
}

/** As it is for a scan on which these were placed before, `certain` among them. */
export const startLandmarks = (picks: Picks = {}, certain: readonly string[] = [], saving: LandmarksSlice["saving"] = "saved"): LandmarksSlice => ({
  picks: startHistory(picks),
  certain: certainAt(picks, certain),
  proposals: null,
  skipped: new Set(),
  active: null,
  saving,
});

export const pickCount = (state: Pick<LandmarksSlice, "picks">): number => Object.keys(state.picks.present).filter((name) => !isMark(name)).length;
