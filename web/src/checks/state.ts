// What is worth checking on a fit: the points that the service names, and whatever else is asked of a person; and the tour that
// goes from one to the next.
import type { Checks, Vector } from "../api/types";
import { saidWide } from "../fit/fingers";
import { type FitSlice, isUnusable } from "../fit/state";
import { isStanceAsked } from "../fit/verdict";
import type { Asks } from "../fit/VerdictBox";
import { type Asked, openQuestions, type Question } from "../landmarks/questions/questions";
import * as text from "./text";

export type Check = Checks["checks"][number];
export type TourStep = { readonly kind: "point"; readonly check: Check; readonly before: number | null } | { readonly kind: "question"; readonly question: Question } | { readonly kind: "stance" };

export interface Tour {
  readonly fit: string; // id of the fit that is checked
  readonly steps: readonly TourStep[];
  readonly at: number; // as many as there are steps: the fit that knows the answers is on its way
  readonly answers: Readonly<Record<string, Vector | null>>; // by landmark: where it is; null: it cannot be seen
  readonly moved: Vector | null; // where a hand has put the point of this step
  readonly before: number | null; // mm, line error
  readonly wasComparing: boolean; // two bodies were on the stage: they are again when it is over
  readonly leadsToFit: boolean; // something was answered that another fit has to know
}

export interface ChecksState {
  readonly of: Readonly<Record<string, Checks | null>>; // by fit, as it was asked last; null: the service did not say
  readonly awaited: ReadonlySet<string>; // fits whose plan has changed since
  readonly tour: Tour | null;
  readonly outcome: { readonly fit: string; readonly from: number | null; readonly to: number | null } | null; // line error before and after the tour that led to this fit
}

export interface ChecksSlice {
  readonly checks: ChecksState;
}

export const initialChecks: ChecksState = { of: {}, awaited: new Set(), tour: null, outcome: null };

type Shown = ChecksSlice & Pick<FitSlice, "fit"> & Asked;

const checksOf = ({ checks, fit }: Pick<Shown, "checks"> & { readonly fit: { readonly id: string } | null }): Checks | null => checks.of[fit?.id ?? ""] ?? null;

/** The service was asked what is worth checking on this fit, and has answered or failed. */
export const areChecksKnown = ({ checks, fit }: Pick<Shown, "checks" | "fit">): boolean => fit?.state !== "done" || isUnusable({ fit }) || checks.of[fit.id] !== undefined;

/** The plan on this fit has changed, and what is worth checking for it is not known yet. */
export const areChecksAwaited = ({ checks, fit }: Pick<Shown, "checks" | "fit">): boolean => checks.awaited.has(fit?.id ?? "");

/** In the order in which they are asked: what contradicts the rest, how the patient stands or lies, and the points that narrow the lines. */
export function stepsOf(state: Shown): TourStep[] {
  const { fit } = state;
  if (fit?.state !== "done" || isUnusable(state)) return [];
  const found = checksOf(state);
  const points = found?.worth_it ? found.checks.map((check, i): TourStep => ({ kind: "point", check, before: i === 0 ? found.line_error_mm : found.checks[i - 1]!.line_error_mm })) : [];
  return [...openQuestions(state).map((question): TourStep => ({ kind: "question", question })), ...(isStanceAsked(fit.result) ? [{ kind: "stance" } as const] : []), ...points];
}

/** What the verdict says of it. */
export function asksOf(state: Shown): Asks {
  const { checks: { outcome }, fit } = state;
  const steps = stepsOf(state);
  const points = steps.filter(({ kind }) => kind === "point").length;
  return { isKnown: areChecksKnown(state), count: steps.length, points, expected: points > 0 ? (checksOf(state)?.expected_line_error_mm ?? null) : null, outcome: outcome && outcome.fit === fit?.id ? outcomeWords(outcome) : "" };
}

/** Whether the tour has narrowed the lines, by as much as a person can see. */
export function outcomeWords({ from, to }: NonNullable<ChecksState["outcome"]>): string {
  const isNarrower = from !== null && to !== null && Math.round(to) < Math.round(from);
  return isNarrower ? text.checks.narrowed(saidWide(from), saidWide(to)) : text.checks.notNarrowed(saidWide(to));
}

export const stepNow = ({ checks: { tour } }: ChecksSlice): TourStep | null => tour?.steps[tour.at] ?? null;

/** Where the point of this step is by now. */
export const placeNow = (tour: Tour): Vector | null => {
  const step = tour.steps[tour.at];
  return step?.kind === "point" ? (tour.moved ?? step.check.place) : null;
};

/** Share of the halo's width that the answers so far leave it, as the service expects; 1 where it says nothing. */
export function narrowing({ checks: { tour } }: ChecksSlice): number {
  if (!tour?.before) return 1;
  const answered = tour.steps.filter((step, i) => step.kind === "point" && (i === tour.at ? tour.moved !== null : i < tour.at && tour.answers[step.check.name] != null));
  const last = answered.at(-1);
  return last?.kind === "point" ? Math.min(1, last.check.line_error_mm / tour.before) : 1;
}
