// Landmarks that the service proposes on a scan.  They are open until a person confirms them, one by one or all at once.
import type { ProposedLandmark } from "../api/types";
import type { Picks } from "./picks";

export type Proposed = Readonly<Record<string, ProposedLandmark>>;
export type OpenProposal = ProposedLandmark & { readonly name: string };

export type Proposals =
  | { readonly state: "looking" }
  | { readonly state: "found"; readonly landmarks: Proposed }
  | { readonly state: "none"; readonly reason: string };

const HALF_SURE_MM = 10; // the error at which the service calls itself half sure
const LIKELY = 0.5;

/** How far off the service expects a proposal to be, from its confidence 1 / (1 + (error / 10 mm)²). */
export function expectedErrorMm(confidence: number): number {
  return HALF_SURE_MM * Math.sqrt(1 / Math.max(confidence, 0.01) - 1);
}

/** Proposals for landmarks that nobody has placed yet. */
export function openProposals(proposals: Proposals | null, picks: Picks): OpenProposal[] {
  if (proposals?.state !== "found") return [];
  return Object.entries(proposals.landmarks).flatMap(([name, each]) => (name in picks ? [] : [{ name, ...each }]));
}

/** Good enough to be confirmed together with others; the rest wants a look of its own. */
export const isLikely = (proposal: ProposedLandmark): boolean => proposal.on_scan && proposal.confidence >= LIKELY;
