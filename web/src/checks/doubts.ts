// What a person has to say before anything is made of a scan or a file: shown in the card of the check until there is an answer.
import type { DrawingSlice } from "../drawing/state";
import type { FitSlice } from "../fit/state";
import { isSizeAsked, type ScanSlice } from "../scan/state";
import type { StancesSlice } from "../stances/state";

export type Doubt = "file" | "patient" | "drawing" | "size";

export type Doubtful = Pick<ScanSlice & FitSlice & DrawingSlice & StancesSlice, "asked" | "scan" | "confirmed" | "fit" | "drawn" | "stances">;

/** What a file leaves open (which side is left, which series it is, whether lesions lie in this image), whether two scans or a drawing are this patient's, the size; null: nothing is asked. */
export function openDoubt(state: Doubtful): Doubt | null {
  if (state.asked) return "file";
  if (state.stances.asked.length > 0) return "patient";
  if (state.drawn.another) return "drawing";
  return isSizeAsked(state) && state.fit === null ? "size" : null; // where there is a fit somebody has made it with this size
}
