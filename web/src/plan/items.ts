// The plan as plain values: which of its items are lines, patterns and the tumour of one scan, put back after a change,
// and brought together with what somebody else has changed meanwhile.
import type { PlanItem, PlanLesion, PlanLine, PlanNote, PlanPattern, PlanTumour, Vector } from "../api/types";
import { lineAlong } from "../drawing/lines/edits";
import { roundMm } from "../drawing/lines/files";
import { INK, newId, type OwnLine } from "../drawing/lines/lines";
import type { PlanStep } from "../drawing/state";
import { type DrawingRequest, parametersOf, readRequest, requestText, type Values } from "../fit/requestedDrawing";

type Items = readonly PlanItem[];

const isLine = (item: PlanItem): item is PlanLine => item.kind === "line";
const isPattern = (item: PlanItem): item is PlanPattern => item.kind === "pattern";
const isLesion = (item: PlanItem): item is PlanLesion => item.kind === "lesion";
const isTumour = (item: PlanItem): item is PlanTumour => item.kind === "tumour";

/** The pen's lines on a scan. */
export const linesOn = (items: Items, scan: string): OwnLine[] =>
  items.filter(isLine).filter((item) => item.scan === scan).map(({ id, name, color, points, closed, bridged, ink, mirrored, depth_mm }) => ({ ...lineAlong(name, color ?? INK, points, closed ?? false, bridged), id, ...(ink?.length ? { ink } : {}), ...(mirrored ? { mirrored } : {}), ...(depth_mm ? { depthMm: depth_mm } : {}) }));

/** What a fit of the scan is asked to bring along: its first pattern and its first tumour, as one text. */
export function drawingOn(items: Items, scan: string): string {
  const here = items.filter((item) => item.scan === scan);
  const pattern = here.find(isPattern);
  const tumour = here.find(isTumour);
  const request: DrawingRequest = { base: pattern?.name ?? "", values: pattern ? texts(pattern.parameters ?? {}) : {}, tumour: tumour ? valuesOf(tumour) : null };
  return requestText(request);
}

const texts = (parameters: PlanPattern["parameters"]): Values => Object.fromEntries(Object.entries(parameters ?? {}).map(([name, value]) => [name, String(value)]));
const valuesOf = ({ side, clock, distance_mm, radius_mm }: PlanTumour): Values => ({ side, clock: String(clock), distance_mm: String(distance_mm), radius_mm: String(radius_mm) });

/** The items with these lines on the scan; a line without an id keeps that of the item with its name, one that says the same stays as it is. */
export function withLines(items: Items, scan: string, lines: readonly OwnLine[]): Items {
  const before = items.filter(isLine).filter((item) => item.scan === scan);
  const known = new Map(before.map((item) => [sorted(lineItem(linesOn([item], scan)[0]!, item.id, scan)), item]));
  const after = lines.map((line): PlanLine => {
    const item = lineItem(line, line.id ?? before.find(({ name }) => name === line.name)?.id ?? newId(), scan);
    return known.get(sorted(item)) ?? item;
  });
  if (after.length === before.length && after.every((item, i) => item === before[i])) return items;
  return [...items.filter((item) => !(isLine(item) && item.scan === scan)), ...after];
}

const lineItem = (line: OwnLine, id: string, scan: string): PlanLine => ({ kind: "line", id, scan, name: line.name, label: "", closed: line.closed, color: line.color, points: line.points.map((point) => point.map(roundMm) as Vector), ...(line.bridged ? { bridged: [...line.bridged] } : {}), ...(line.ink ? { ink: [...line.ink] } : {}), ...(line.mirrored ? { mirrored: true } : {}), ...(line.depthMm ? { depth_mm: line.depthMm } : {}) });

/** The items with this pattern and tumour on the scan, instead of the first ones; what they were keeps its id. */
export function withDrawing(items: Items, scan: string, text: string): Items {
  if (drawingOn(items, scan) === text) return items;
  const { base, values, tumour } = readRequest(text);
  const here = items.filter((item) => item.scan === scan);
  const [oldPattern, oldTumour] = [here.find(isPattern), here.find(isTumour)];
  const rest = items.filter((item) => item !== oldPattern && item !== oldTumour);
  const parameters = parametersOf(values);
  const pattern: PlanPattern[] = base === "" ? [] : [{ kind: "pattern", id: oldPattern?.id ?? newId(), scan, name: base, parameters }];
  const number = (name: string): number => Number(tumour?.[name]);
  const circle: PlanTumour[] = tumour && ["L", "R"].includes(tumour.side ?? "") && ["clock", "distance_mm", "radius_mm"].every((name) => tumour[name])
    ? [{ ...oldTumour, kind: "tumour", id: oldTumour?.id ?? newId(), scan, side: tumour.side === "R" ? "R" : "L", clock: number("clock"), distance_mm: number("distance_mm"), radius_mm: number("radius_mm") }]
    : [];
  return [...rest, ...pattern, ...circle];
}

/** What is said about the scan's plan as a whole; notes with a place of their own are others. */
export const noteOn = (items: Items, scan: string): string => {
  const note = items.find((item): item is PlanNote => item.kind === "note" && item.scan === scan && item.point == null);
  return note?.text ?? "";
};

export function withNote(items: Items, scan: string, text: string): Items {
  if (noteOn(items, scan) === text.trim()) return items;
  const old = items.find((item) => item.kind === "note" && item.scan === scan && item.point == null);
  const rest = items.filter((item) => item !== old);
  return text.trim() === "" ? rest : [...rest, { kind: "note", id: old?.id ?? newId(), scan, text: text.trim() }];
}

/** mm below the skin, of the tumour that `drawingOn` names; null where it is not known. */
export const depthOn = (items: Items, scan: string): number | null => items.filter(isTumour).find((item) => item.scan === scan)?.depth_mm ?? null;

export function withDepth(items: Items, scan: string, mm: number | null): Items {
  const tumour = items.filter(isTumour).find((item) => item.scan === scan);
  if ((tumour?.depth_mm ?? null) === mm || !tumour) return items;
  return items.map((item) => (item === tumour ? { ...tumour, depth_mm: mm } : item));
}

/** Lesions inside the body that were given on a scan. */
export const lesionsOn = (items: Items, scan: string): PlanLesion[] => items.filter(isLesion).filter((item) => item.scan === scan);

export const withLesions = (items: Items, scan: string, lesions: readonly PlanLesion[]): Items =>
  sorted(lesionsOn(items, scan)) === sorted(lesions) ? items : [...items.filter((item) => !(isLesion(item) && item.scan === scan)), ...lesions];

/** All that the items say about one scan, as one step of undoing. */
export const stepOn = (items: Items, scan: string): PlanStep => ({ lines: linesOn(items, scan), drawing: drawingOn(items, scan), note: noteOn(items, scan), depthMm: depthOn(items, scan), lesions: lesionsOn(items, scan) });

/** The items with all that a step says about the scan. */
export const withStepOn = (items: Items, scan: string, { lines, drawing, note, depthMm, lesions }: PlanStep): Items =>
  withLesions(withDepth(withNote(withDrawing(withLines(items, scan, lines), scan, drawing), scan, note), scan, depthMm), scan, lesions);

/**
 * What both wanted: `mine` and `theirs` each began with `base`.  Where both changed one line or lesion, mine stays and theirs is
 * kept beside it under another name, so that nothing anybody drew is lost; of notes both texts stay.  Of the one pattern and the
 * one tumour that the page shows of a scan mine stays: who asks says so (`stepTogether`).  Where one deleted what the other
 * changed, the change stays.
 */
export function merged(base: Items, myOwn: Items, theirs: Items): PlanItem[] {
  const mine = asTheirs(base, myOwn, theirs);
  const find = (items: Items, id: string): PlanItem | undefined => items.find((item) => item.id === id);
  const same = (a: PlanItem | undefined, b: PlanItem | undefined): boolean => sorted(a) === sorted(b);
  const found: PlanItem[] = [];
  for (const item of theirs) {
    const [before, own] = [find(base, item.id), find(mine, item.id)];
    if (same(item, before)) {
      if (own) found.push(own); // they left it alone: as I have it, or gone
    } else if (same(own, before) || same(own, item)) found.push(item);
    else if (!own) found.push(item);
    else if (own.kind === "note" && item.kind === "note") found.push({ ...own, text: bothTexts(own.text, item.text) });
    else if (isOnly(own, mine)) found.push(own);
    else found.push(own, beside(item));
  }
  for (const item of mine) {
    const before = find(base, item.id);
    if (find(theirs, item.id)) continue;
    if (!before || !same(item, before)) found.push(item); // new, or changed while they deleted it
  }
  return named(found);
}

const LONGEST_NOTE = 2000; // as the service takes it

const bothTexts = (mine: string, theirs: string): string => (mine.includes(theirs) ? mine : theirs.includes(mine) ? theirs : `${mine}\n${theirs}`.slice(0, LONGEST_NOTE));

/** The kinds of which the page shows one on each scan. */
const isSingle = (item: PlanItem): boolean => isPattern(item) || isTumour(item) || (item.kind === "note" && item.point == null);
const onlyOf = ({ kind, scan }: PlanItem, items: Items): PlanItem | undefined => items.find((item) => isSingle(item) && item.kind === kind && item.scan === scan);
const isOnly = (item: PlanItem, items: Items): boolean => isSingle(item) && onlyOf(item, items) === item;

/** Mine, where both began the one pattern, tumour or note of a scan: they are one item. */
const asTheirs = (base: Items, mine: Items, theirs: Items): Items =>
  mine.map((item) => {
    const other = isOnly(item, mine) ? onlyOf(item, theirs) : undefined;
    const isNewInBoth = other && other.id !== item.id && ![item.id, other.id].some((id) => base.some((each) => each.id === id));
    return isNewInBoth ? { ...item, id: other.id } : item;
  });

/** The pattern, tumour and depth that were planned elsewhere, where they were changed here too, in another way. */
export type Contested = Pick<PlanStep, "drawing" | "depthMm">;

/** What is shown of one scan, `step`, brought together with what the plan says `now`, where it said `base` when it was shown; and what of `now` had to give way. */
export function stepTogether(base: Items, step: PlanStep, now: Items, scan: string): { readonly step: PlanStep; readonly contested: Contested | null } {
  const here = (items: Items): PlanItem[] => items.filter((item) => item.scan === scan);
  const [before, mine, theirs] = [here(base), here(withStepOn(base, scan, step)), here(now)];
  const both = merged(before, mine, theirs);
  const contested = contestedOn(before, mine, theirs, scan);
  const known = new Map(here(withLines([], scan, step.lines)).map((item, i) => [sorted(item), step.lines[i]!]));
  const bothLines = both.filter(isLine);
  const lines = linesOn(both, scan).map((line, i) => known.get(sorted(lineItem(line, bothLines[i]!.id, scan))) ?? line);
  const isSame = lines.length === step.lines.length && lines.every((line, i) => line === step.lines[i]);
  const { drawing, note, depthMm, lesions } = stepOn(both, scan);
  return { step: { ...step, lines: isSame ? step.lines : lines, drawing, note, depthMm: drawing === step.drawing && !both.some(isTumour) ? step.depthMm : depthMm, lesions: sorted(lesions) === sorted(step.lesions) ? step.lesions : lesions }, contested };
}

/** As it would be if theirs stayed, where that is another pattern, tumour or depth. */
export function contestedOn(base: Items, mine: Items, theirs: Items, scan: string): Contested | null {
  const [own, other] = [merged(base, mine, theirs), merged(base, theirs, mine)];
  const [drawing, depthMm] = [drawingOn(other, scan), depthOn(other, scan)];
  return drawing === drawingOn(own, scan) && depthMm === depthOn(own, scan) ? null : { drawing, depthMm };
}

const beside = (item: PlanItem): PlanItem => ({ ...item, id: newId() });

/** Two lines of one scan may not have one name. */
function named(items: Items): PlanItem[] {
  const taken = new Set<string>();
  return items.map((item) => {
    if (!isLine(item)) return item;
    let name = item.name;
    for (let number = 2; taken.has(`${item.scan ?? ""}/${name}`); number += 1) name = `${item.name} ${number}`;
    taken.add(`${item.scan ?? ""}/${name}`);
    return { ...item, name };
  });
}

/** A text that is the same for equal values, whatever the order of their parts. */
function sorted(value: unknown): string {
  return JSON.stringify(value, (_key, part: unknown) =>
    part !== null && typeof part === "object" && !Array.isArray(part)
      ? Object.fromEntries(Object.entries(part).filter(([, each]) => each != null && each !== "").sort(([a], [b]) => (a < b ? -1 : 1)))
      : typeof part === "number" ? Math.round(part / ROUNDED) * ROUNDED : part,
  );
}

const ROUNDED = 1e-6; // by another size and back

/** The items of a scan that is so many times as large; what was said in millimetres of the patient stays. */
export function timesLarger(items: Items, factorOf: (scan: string) => number): PlanItem[] {
  return items.map((item) => {
    const factor = factorOf(item.scan ?? "");
    const at = (place: Vector): Vector => place.map((value) => factor * value) as unknown as Vector;
    if (factor === 1) return item;
    if (isLine(item)) return { ...item, points: item.points.map(at) };
    if (isLesion(item)) return { ...item, center: at(item.center) };
    return item.kind === "note" && item.point ? { ...item, point: at(item.point) } : item;
  });
}
