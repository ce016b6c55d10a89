// The pattern (or drawing of the model) and the tumour by the clock that are planned on one scan, as one text that is
// compared and kept on this page only, for instance lumpectomy+tumour:side=L,clock=10,distance_mm=45,radius_mm=12.
import type { Meta, PatternInfo, PatternParameter } from "../api/types";

export type Values = Readonly<Record<string, string>>;

export interface DrawingRequest {
  /** a drawing of the model or a pattern; empty for none */
  readonly base: string;
  /** of the pattern: what was given, as written; what is missing has its default */
  readonly values: Values;
  readonly tumour: Values | null;
}

export const TUMOUR = "tumour";

function partOf(name: string, values: Values): string {
  const given = Object.entries(values).filter(([, value]) => value !== "");
  return given.length === 0 ? name : `${name}:${given.map(([key, value]) => `${key}=${value}`).join(",")}`;
}

export function requestText({ base, values, tumour }: DrawingRequest): string {
  return [...(base === "" ? [] : [partOf(base, values)]), ...(tumour ? [partOf(TUMOUR, tumour)] : [])].join("+");
}

function read(part: string): { name: string; values: Values } {
  const [name = "", written = ""] = part.split(/:(.*)/s);
  const pairs = written.split(",").flatMap((pair) => (pair.includes("=") ? [pair.split("=", 2) as [string, string]] : []));
  return { name: name.trim(), values: Object.fromEntries(pairs.map(([key, value]) => [key.trim(), value.trim()])) };
}

/** As the service takes them: numbers as numbers. */
export const parametersOf = (values: Values): Record<string, number | string> =>
  Object.fromEntries(Object.entries(values).filter(([, value]) => value !== "").map(([name, value]) => [name, value.trim() !== "" && Number.isFinite(Number(value)) ? Number(value) : value]));

export function readRequest(text: string): DrawingRequest {
  const parts = text.split("+").filter((part) => part.trim() !== "").map(read);
  const base = parts.find(({ name }) => name !== TUMOUR);
  return { base: base?.name ?? "", values: base?.values ?? {}, tumour: parts.find(({ name }) => name === TUMOUR)?.values ?? null };
}

/** What a field shows before anybody has touched it; what is needed is the patient's, and nobody but a person knows it. */
export const startValue = (parameter: PatternParameter): string => (parameter.default === null ? "" : String(parameter.default));

const SIDES = { R: "right", L: "left" } as const;
type Side = keyof typeof SIDES;

/** A parameter of one side alone, as the service names it. */
export const nameOn = (name: string, side: Side): string => `${name}_${SIDES[side]}`;

/** Whether right and left have numbers of their own. */
export const areApart = (values: Values): boolean => Object.keys(values).some((name) => /_(left|right)$/.test(name));

/** What is asked of a parameter, on one side where those differ; empty where nothing is. */
export const valueOn = (values: Values, parameter: PatternParameter, side: Side | null): string => (side ? values[nameOn(parameter.name, side)] : undefined) ?? values[parameter.name] ?? startValue(parameter);

const choicesOf = (values: Values, parameters: readonly PatternParameter[]): Values => Object.fromEntries(parameters.flatMap(({ name, choices }) => (choices && values[name] !== undefined ? [[name, values[name]]] : [])));

/** Each number as one of the right and one of the left. */
export const setApart = (values: Values, parameters: readonly PatternParameter[]): Values => ({
  ...choicesOf(values, parameters),
  ...Object.fromEntries(parameters.filter(({ choices }) => !choices).flatMap((each) => (["R", "L"] as const).map((side) => [nameOn(each.name, side), valueOn(values, each, side)]))),
});

/** The numbers of one side for both. */
export const setTogether = (values: Values, parameters: readonly PatternParameter[], side: Side): Values => ({
  ...choicesOf(values, parameters),
  ...Object.fromEntries(parameters.filter((each) => !each.choices && valueOn(values, each, side) !== startValue(each)).map((each) => [each.name, valueOn(values, each, side)])),
});

/** What has to be given still, before there is anything to draw. */
export const stillNeeded = (pattern: PatternInfo, values: Values): readonly PatternParameter[] => pattern.parameters.filter(({ name, needed }) => needed && (values[name] ?? "") === "");

const OTHER: Readonly<Record<string, string>> = { L: "R", R: "L" };

/** On the patient's other side, the hour exchanged with it; null for what has no side, or both. */
export function mirroredValues(values: Values): Values | null {
  const side = OTHER[values.side ?? ""];
  if (side === undefined) return null;
  const hour = Number(values.clock);
  return { ...values, side, ...(values.clock && Number.isFinite(hour) ? { clock: String(mirroredHour(hour)) } : {}) };
}

/** As read by an observer facing the patient, 0.5 to 12.5: 10 o'clock on one breast lies where 2 o'clock does on the other. */
const mirroredHour = (hour: number): number => Math.round(100 * (hour > 11.5 ? 24 - hour : 12 - hour)) / 100;

export const drawingLabels = ({ meta }: { meta: Meta | null }): ReadonlyMap<string, string> =>
  new Map([...(meta?.patterns ?? []), ...(meta?.drawings ?? [])].map(({ name, label }) => [name, label]));
