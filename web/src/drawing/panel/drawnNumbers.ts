// What the drawn lines of a pattern measure on each side, beside what was asked for.
import type { PatternParameter } from "../../api/types";
import { startValue, type Values, valueOn } from "../../fit/requestedDrawing";
import type { LiveHandle, LivePart } from "../state";
import { planPanel as words, type Side } from "./text";

const SAME: Readonly<Record<string, number>> = { h: 0.05 }; // what a field rounds, and a line on the scan beside one on the model
const SAME_MM = 1; // degrees, too
const BY_ITSELF: Readonly<Record<string, number>> = { limb_mm: 50 }; // drawn so long where nothing is said and there is room

export interface DrawnNumber {
  /** what the lines measure, where that is not what was asked for; else what was asked; null: chosen by the service */
  readonly value: number | null;
  readonly drawn: number | null; // null before it is drawn
  readonly isForced: boolean;
}

/** The columns of a pattern: its sides, the patient's right first, as an observer has them; one without a letter where no side is said. */
export function columnsOf(values: Values, parameters: readonly PatternParameter[]): readonly (Side | null)[] {
  const side = parameters.find(({ name }) => name === "side");
  const said = side ? (values.side ?? startValue(side)) : "";
  return said === "both" ? ["R", "L"] : said === "L" || said === "R" ? [said] : [null];
}

export function drawnNumber(parameter: PatternParameter, values: Values, part: LivePart, side: Side | null, handles: readonly LiveHandle[]): DrawnNumber {
  const given = valueOn(values, parameter, side);
  const asked = given === "" ? null : Number(given);
  const drawn = measuredOn(parameter.name, handles.filter((each) => each.part === part && (side === null || each.side === side)));
  const wanted = asked ?? BY_ITSELF[parameter.name] ?? null;
  const isForced = drawn !== null && wanted !== null && apart(drawn, wanted, parameter.unit) >= (SAME[parameter.unit] ?? SAME_MM) && !(asked === null && drawn > wanted);
  const rounded = drawn === null ? null : parameter.unit === "h" ? drawn : Math.round(drawn);
  return { value: isForced && asked !== null ? rounded : asked, drawn: rounded, isForced };
}

/** Why numbers are drawn otherwise than asked, a sentence for each parameter. */
export function reasonsOf(parameters: readonly PatternParameter[], values: Values, part: LivePart, handles: readonly LiveHandle[]): readonly string[] {
  const sides = columnsOf(values, parameters);
  return parameters.flatMap((parameter) => {
    const forced = sides.map((side) => ({ given: valueOn(values, parameter, side), ...drawnNumber(parameter, values, part, side, handles) })).filter(({ isForced }) => isForced);
    if (forced.length === 0) return [];
    if (parameter.name === "nipple_above_fold_mm" && forced.every(({ given, drawn }) => drawn! > Number(given))) return [words.reasons.nipple_above_fold_mm];
    return [...new Set(forced.map(({ given }) => (given === "" ? words.reasons.limb_mm : words.reasons.other(parameter.label, Number(given), parameter.unit))))];
  });
}

function measuredOn(parameter: string, handles: readonly LiveHandle[]): number | null {
  const own = handles.find(({ numbers }) => numbers.some((each) => each.parameter === parameter));
  const measured = (own ?? handles.find((each) => each.measured?.[parameter] !== undefined))?.measured?.[parameter];
  return measured ?? own?.numbers.find((each) => each.parameter === parameter)?.value ?? null;
}

/** How far two numbers are apart; an axis is the same after half a turn, an hour after twelve. */
function apart(one: number, other: number, unit: string): number {
  const off = Math.abs(one - other);
  const round = { deg: 180, h: 12 }[unit];
  return round === undefined ? off : Math.min(off, Math.abs(round - off));
}
