// How far a fit may be trusted, in words: the service's own verdict, before any number.
import type { Result } from "../api/types";
import { formatMmWhole } from "../ui/units";
import * as text from "./text";

const words = text.numbers;
export const KNOWN_MM = 60; // a larger radius is that of a breast or more: nothing is known of the place, as the service says

/** "± 6 mm", of a radius that holds nine of ten places. */
export const marginOf = (mm: number): string => (mm > KNOWN_MM ? words.unknown : `±\u00a0${formatMmWhole(mm)}\u00a0mm`);

/** "± 3 to 8 mm", or one number where all round to the same; those that are not known are counted. */
export function marginsOf(radii: readonly number[]): string {
  const known = radii.filter((mm) => mm <= KNOWN_MM).map(Math.round);
  if (known.length === 0) return words.unknown;
  const [least, most] = [Math.min(...known), Math.max(...known)];
  return `± ${least === most ? most : `${least} to ${most}`} mm${known.length < radii.length ? `, ${words.notKnown(radii.length - known.length)}` : ""}`;
}

/** good where a result of an older version has no verdict, so that nothing is called doubtful without a reason. */
export const levelOf = (result: Pick<Result, "verdict"> | null | undefined): NonNullable<Result["verdict"]>["level"] => result?.verdict?.level ?? "good";

/** The scan did not show clearly how the patient stands or lies: the fit has guessed, and asks. */
export const isStanceAsked = (result: Pick<Result, "stance_asked"> | null | undefined): boolean => result?.stance_asked ?? false;

/** In one line, for those who listen. */
export const verdictWords = ({ verdict }: Pick<Result, "verdict">): string => (verdict ? [`${words.verdicts[verdict.level]}.`, ...verdict.reasons].join(" ") : "");
