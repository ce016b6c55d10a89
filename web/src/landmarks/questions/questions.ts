// What is asked about picks: by the fit, where all else contradicts one or where it is unusual, and by the sides of the
// body before any fit.  A question is open until it is answered: kept, taken out, exchanged, or simply placed elsewhere.
import { capital, inSentence } from "../../languages/words";
import type { Frame, LandmarkDefinition, Unit, Vector } from "../../api/types";
import { mmFrom } from "../../ui/units";
import { type Certain, isCertain } from "../certain";
import { onWrongSide, partnerOf, type Picks } from "../picks";
import * as text from "../text";

interface Doubted {
  readonly names: readonly string[];
  readonly reason: string;
}

interface JudgedResult {
  readonly landmarks_not_followed?: readonly Doubted[];
  readonly landmarks_unusual?: readonly Doubted[];
  readonly landmarks_picked?: Readonly<Record<string, Vector>>;
  readonly scan?: { readonly unit: string };
}

/** What of a fit decides. */
export interface Judgement {
  readonly started: Pick<JudgedResult, "landmarks_not_followed"> | null;
  readonly result: JudgedResult | null;
  readonly before?: JudgedResult | null; // while it runs: the result that it takes the place of
  readonly picks: Picks | null;
}

export interface Asked {
  readonly fit: Judgement | null;
  readonly scan: { readonly frame: Frame } | null;
  readonly picks: { readonly present: Picks };
  readonly certain: Certain;
}

export interface Question extends Doubted {
  /** One answer repairs it: two sides, two others, or all sides take each other's place; null for a single pick. */
  readonly exchange: "sides" | "two" | "all" | null;
}

const SAME_MM = 0.01; // what a result's rounding leaves; a nudge of one pixel is more

/** All that is asked about the picks as they are now. */
export function openQuestions({ fit, scan, picks, certain }: Asked): Question[] {
  const present = picks.present;
  const asked = fit ? askedBy(fit, present).filter(({ names }) => !names.some((name) => isCertain(present, certain, name))) : [];
  const named = new Set(asked.flatMap(({ names }) => names));
  const swapped = scan ? [...onWrongSide(present, scan.frame)].filter((name) => !named.has(name) && !isCertain(present, certain, name)) : [];
  const ofSides = swapped.length > 1 ? [question({ names: swapped, reason: text.questions.wrongSide(swapped.length > 2) })] : [];
  return [...asked.map(question), ...ofSides];
}

/** The names of all picks that are asked about. */
export const askedNames = (questions: readonly Question[]): ReadonlySet<string> => new Set(questions.flatMap(({ names }) => names));

/** What the fit doubts, where the picks are still those that it was given. */
function askedBy(fit: Judgement, present: Picks): Doubted[] {
  const early = fit.started?.landmarks_not_followed ?? [];
  const judged = fit.result ?? (early.length > 0 ? null : fit.before) ?? null;
  const doubts = judged ? [...(judged.landmarks_not_followed ?? []), ...(judged.landmarks_unusual ?? [])] : early;
  const given = judged ? inMm(judged) : fit.picks;
  return doubts.filter(({ names }) => names.every((name) => name in present && isNear(present[name]!, given?.[name])));
}

/** The picks that a result was made with; null when it is of a version that did not keep them. */
function inMm({ landmarks_picked: places, scan }: JudgedResult): Picks | null {
  if (!places || !scan) return null;
  const toMm = ([x, y, z]: Vector): Vector => [mmFrom(x, scan.unit as Unit), mmFrom(y, scan.unit as Unit), mmFrom(z, scan.unit as Unit)];
  return Object.fromEntries(Object.entries(places).map(([name, place]) => [name, toMm(place)]));
}

const isNear = (at: Vector, given: Vector | undefined): boolean =>
  given === undefined || Math.hypot(at[0] - given[0], at[1] - given[1], at[2] - given[2]) < SAME_MM;

function question({ names, reason }: Doubted): Question {
  const [first, second] = names;
  if (names.length > 2) return { names, reason, exchange: "all" };
  if (names.length === 2) return { names, reason, exchange: partnerOf(first!) === second ? "sides" : "two" };
  return { names, reason, exchange: null };
}

/** The reason as a sentence, with the landmarks' labels in place of their names: it may name others than are asked about. */
export function sentenceOf({ reason }: Doubted, list: readonly Pick<LandmarkDefinition, "name" | "label">[]): string {
  const labels = new Map(list.map(({ name, label }) => [name, inSentence(label)]));
  const labelled = reason.replaceAll(/\b[a-z]\w*\b/g, (word) => labels.get(word) ?? word);
  return capital(labelled);
}
