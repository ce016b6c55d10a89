// What a step of the plan's history has changed, in words: undo and redo say it.
import type { PatternInfo, PatternParameter } from "../api/types";
import { areApart, readRequest, TUMOUR, type Values, valueOn } from "../fit/requestedDrawing";
import type { OwnLine } from "./lines/lines";
import type { PlanStep } from "./state";
import * as text from "./text";

const words = text.changes;

/** A pattern of the service, or a drawing of the model, which has no numbers. */
type Named = Pick<PatternInfo, "name" | "label"> & Partial<Pick<PatternInfo, "parameters">>;

export function planChanges(before: PlanStep, after: PlanStep, known: readonly Named[]): string {
  const said = [...linesChanged(before.lines, after.lines), ...drawingChanged(before.drawing, after.drawing, known)];
  if (before.depthMm !== after.depthMm) said.push(words.number(words.depth, words.depthOf(before.depthMm), words.depthOf(after.depthMm)));
  if (!isSame(before.lesions, after.lesions)) said.push(words.lesions);
  if (before.note !== after.note) said.push(words.note);
  if (before.decided && after.decided && !isSame(before.decided, after.decided)) said.push(words.ink);
  return said.length > 0 ? said.join(", ") : words.nothing;
}

const isSame = (one: unknown, other: unknown): boolean => one === other || JSON.stringify(one) === JSON.stringify(other);

const keyOf = ({ id, name }: OwnLine): string => id ?? name;

function linesChanged(before: readonly OwnLine[], after: readonly OwnLine[]): string[] {
  const [earlier, later] = [before, after].map((lines) => new Map(lines.map((line) => [keyOf(line), line]))) as [Map<string, OwnLine>, Map<string, OwnLine>];
  const namesOf = (lines: readonly OwnLine[]): string[] => lines.map(({ name }) => name);
  const drawn = namesOf(after.filter((line) => !earlier.has(keyOf(line))));
  const erased = namesOf(before.filter((line) => !later.has(keyOf(line))));
  return [
    ...(drawn.length > 0 ? [words.drawn(drawn)] : []),
    ...(erased.length > 0 ? [words.erased(erased)] : []),
    ...after.flatMap((line) => lineChanged(earlier.get(keyOf(line)) ?? line, line)),
  ];
}

function lineChanged(before: OwnLine, after: OwnLine): string[] {
  if (before === after) return [];
  return [
    ...(before.name === after.name ? [] : [words.renamed(before.name, after.name)]),
    ...(before.color === after.color ? [] : [words.recoloured(after.name)]),
    ...(before.closed === after.closed && isSame(before.points, after.points) ? [] : [words.moved(after.name)]),
    ...(before.depthMm === after.depthMm ? [] : [words.deep(after.name, words.depthOf(after.depthMm ?? null))]),
  ];
}

function drawingChanged(before: string, after: string, known: readonly Named[]): string[] {
  if (before === after) return [];
  const [was, is] = [readRequest(before), readRequest(after)];
  const labelOf = (name: string): string => known.find((each) => each.name === name)?.label ?? name;
  const numbers = (name: string, earlier: Values, later: Values): string[] => valuesChanged(known.find((each) => each.name === name)?.parameters ?? [], earlier, later);
  return [
    ...(was.base === is.base ? numbers(is.base, was.values, is.values) : [words.pattern(labelOf(was.base), labelOf(is.base))]),
    ...(was.tumour && is.tumour ? numbers(TUMOUR, was.tumour, is.tumour) : was.tumour || is.tumour ? [words.pattern(was.tumour ? labelOf(TUMOUR) : "", is.tumour ? labelOf(TUMOUR) : "")] : []),
  ];
}

function valuesChanged(parameters: readonly PatternParameter[], before: Values, after: Values): string[] {
  const isApart = [before, after].map(areApart);
  if (isApart[0] !== isApart[1]) return [isApart[1] ? words.apart : words.together];
  return parameters.flatMap((parameter) => {
    const sides = isApart[0] && !parameter.choices ? (["R", "L"] as const) : [null];
    return sides.flatMap((side) => {
      const [was, is] = [valueSaid(parameter, before, side), valueSaid(parameter, after, side)];
      return was === is ? [] : [words.number(side ? words.on(parameter.label, side) : parameter.label, was, is)];
    });
  });
}

function valueSaid(parameter: PatternParameter, values: Values, side: "R" | "L" | null): string {
  const value = valueOn(values, parameter, side);
  if (value === "") return text.drawing.pattern.byItself;
  return parameter.choices ? (text.drawing.pattern.choices[value] ?? value) : text.amount(Number(value), parameter.unit);
}
