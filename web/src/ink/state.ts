// Lines of ink that were found on a scan's skin, until a person has decided about each.
import type { InkShape, Vector } from "../api/types";
import type { InkDecided } from "../drawing/state";
import { type Crops, isCut } from "../scan/crop";

/** One stroke of a pen, as it may become a line of the plan. */
export interface FoundLine {
  readonly name: string; // one of its own among the found lines of the scan
  readonly ids: readonly string[]; // the service's names for it; several when it was joined
  readonly kind: InkShape["kind"];
  readonly marker: InkShape["marker"];
  readonly color: string;
  readonly closed: boolean;
  readonly points: readonly Vector[]; // mm, the scan's own axes
  readonly bridged: readonly boolean[]; // per point: the scan has a hole there
  readonly lengthMm: number;
}

export type Search =
  | { readonly state: "looking" }
  | { readonly state: "failed"; readonly reason: string }
  | { readonly state: "found"; readonly lines: readonly FoundLine[]; readonly kept: readonly string[] }; // ids of those that the service keeps as dropped

export interface InkSlice {
  readonly ink: Readonly<Record<string, Search>>; // by scan
  readonly inkPointed: string | null; // the found line that is pointed at
}

export const initialInk: InkSlice = { ink: {}, inkPointed: null };

/** Beside the plan: crosses, arrows and writing. */
export const isMark = ({ kind }: Pick<FoundLine, "kind">): boolean => kind === "cross" || kind === "arrow" || kind === "writing";

/** Those about which nobody has decided yet, on what is left of the scan; none before it is known. */
export const openLines = (search: Search | undefined, decided: InkDecided | null, crops: Crops): readonly FoundLine[] =>
  search?.state === "found" && decided !== null ? search.lines.filter(({ ids, points }) => ids.some((id) => decided[id] === undefined) && !isCut(points, crops)) : [];

export const droppedIds = (decided: InkDecided | null): string[] => Object.keys(decided ?? {}).filter((id) => decided![id] === "dropped");
