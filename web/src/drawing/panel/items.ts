// What is planned, as the panel lists it: one row for a line, a pattern with all its lines, a tumour, a lesion, a note.
import type { Patient, PlanLesion } from "../../api/types";
import { drawingLabels, readRequest, TUMOUR } from "../../fit/requestedDrawing";
import { type FitSlice, type FitState, isUnusable, modelOf } from "../../fit/state";
import { lineErrorOf, marginOf } from "../../fit/verdict";
import { sideOf } from "../../landmarks/picks";
import { inStance } from "../../scan/text";
import { capital } from "../../languages/words";
import type { PageSlice } from "../../store/page";
import type { LaidLesion } from "../lesions/lesions";
import { lengthOf, ownColour, type OwnLine } from "../lines/lines";
import { type DrawingSlice, type Laid, type Layer, layerKey, shownPatterns } from "../state";
import { drawing } from "../text";
import { planPanel as words } from "./text";

export type Shown = Pick<PageSlice & FitSlice & DrawingSlice, "meta" | "models" | "fit" | "drawing" | "drawn" | "lesion" | "item"> & {
  readonly scan: { readonly info: { readonly id: string } } | null;
  readonly stances: {
    readonly isCarrying: boolean;
    readonly other: { readonly drawing: string; readonly scan: Shown["scan"]; readonly fit: Pick<FitState, "state" | "result"> | null } | null;
    readonly scans: readonly Pick<Patient["scans"][number], "id" | "stance" | "kind" | "fit">[];
    readonly asked: readonly unknown[];
  };
};

/** The scans on which the plan lies, as they are called: those with a fit that can be used; none while it is asked whether they are one patient's. */
export function planScans({ scan, fit, stances: { other, scans, asked } }: Pick<Shown, "scan" | "fit" | "stances">): string[] {
  if (asked.length > 0) return [];
  const here = new Map([[scan?.info.id, fit], [other?.scan?.info.id, other?.fit ?? null]]);
  const isFitted = ({ id, fit: kept }: (typeof scans)[number]): boolean => (here.has(id) ? here.get(id)?.state === "done" && !isUnusable({ fit: here.get(id)! }) : kept?.state === "done" && kept.verdict !== "unusable");
  return scans.filter(isFitted).map(({ kind, stance }) => (kind === "image" ? words.image : inStance(stance)));
}

/** One line on the body, for its row of on and off. */
interface ShownLine {
  readonly name: string;
  readonly label: string;
  readonly colour: string | null;
}

interface Row {
  readonly key: string; // see itemKey
  readonly label: string;
  readonly says: string; // at the right of its row
  readonly hint: string; // how sure its place is
  readonly layer: Layer;
  readonly lines: readonly ShownLine[];
  readonly isHidden: boolean; // all of its lines are switched off
}

export type PlanRow = Row &
  (
    | { readonly kind: "line"; readonly line: OwnLine }
    | { readonly kind: "pattern" | "tumour" | "carried" | "note" }
    | { readonly kind: "lesion"; readonly own: PlanLesion | null; readonly laid: LaidLesion | null }
  );

export const itemKey = {
  pattern: "pattern",
  tumour: TUMOUR,
  note: "note",
  line: (name: string): string => `line ${name}`,
  lesion: (id: string): string => `lesion ${id}`,
  carried: (item: string): string => `carried ${item}`,
};

type RowOf = (layer: Layer, key: string, label: string, of: readonly Shape[], says: string, more?: readonly string[]) => Row;
type Shape = Laid["shapes"][number] | { readonly name: string; readonly label?: string; readonly color?: string; readonly kind?: string; readonly item?: string; readonly line_error_mm?: number | null };

/** A drawing that came with the fit does not say what its lines are of. */
const kindOf = ({ kind, name }: Shape): string => kind ?? (name.startsWith(TUMOUR) ? "tumour" : "pattern");
const ofKind = (shapes: readonly Shape[], kind: string): readonly Shape[] => shapes.filter((shape) => kindOf(shape) === kind);

export function planRows(state: Shown): readonly PlanRow[] {
  const { drawn } = state;
  const asked = readRequest(state.drawing || (drawn.onScan ? "" : (state.fit?.drawingName ?? "")));
  const labels = drawingLabels(state);
  const shapes: readonly Shape[] = shownPatterns(state)?.shapes ?? [];
  const row: RowOf = (layer, key, label, of, says, more = []) => {
    const lines = of.map((shape) => ({ name: shape.name, label: lineLabel(state, shape), colour: ownColour(shape.color) }));
    const mm = lineErrorOf(of);
    return { key, label, says, hint: [...(mm === null ? [] : [mm === 0 ? words.given : marginOf(mm)]), ...more].join(", "), layer, lines, isHidden: lines.length > 0 && lines.every(({ name }) => drawn.hidden.has(layerKey(layer, name))) };
  };
  const own = drawn.lines.present.map((line): PlanRow => ({
    ...row("own", itemKey.line(line.name), line.name, [line], [...(line.mirrored ? [words.mirrored] : []), line.closed ? words.ring : words.length(lengthOf(line)), ...(line.closed && line.depthMm ? [words.deep(line.depthMm)] : [])].join(", "), [words.given]),
    kind: "line",
    line,
  }));
  const ofPattern = ofKind(shapes, "pattern");
  const patterns: PlanRow[] = asked.base === "" ? [] : [{ ...row("reference", itemKey.pattern, labels.get(asked.base) ?? asked.base, ofPattern, words.onScans(sidesSaid(ofPattern), planScans(state))), kind: "pattern" }];
  const deep = drawn.depthMm === null ? words.across(2 * Number(asked.tumour?.radius_mm)) : words.deep(drawn.depthMm);
  const tumours: PlanRow[] = asked.tumour ? [{ ...row("reference", itemKey.tumour, tumourLabel(asked.tumour.side, labels.get(TUMOUR)), ofKind(shapes, "tumour"), deep), kind: "tumour" }] : [];
  const notes: PlanRow[] = drawn.note === "" ? [] : [{ ...row("own", itemKey.note, drawn.note, [], ""), kind: "note" }];
  return [...patterns, ...tumours, ...own, ...lesionRows(state, row), ...carriedRows(state, row), ...notes];
}

/** What was planned on another scan, one row for each item of the plan; lesions have their own. */
function carriedRows(state: Shown, row: RowOf): PlanRow[] {
  const { onScan } = state.drawn;
  const labels = drawingLabels(state);
  const items = new Map<string, readonly Laid["shapes"][number][]>();
  const lesions = new Set(onScan?.plan.lesions.map(({ id }) => id));
  for (const shape of onScan?.carried.shapes ?? []) if (!lesions.has(shape.item)) items.set(shape.item, [...(items.get(shape.item) ?? []), shape]);
  const there = labels.get(readRequest(state.stances.other?.drawing ?? "").base);
  return [...items].map(([item, of]) => {
    const { kind } = of[0]!;
    const label = kind === "tumour" ? (labels.get(TUMOUR) ?? words.tumour) : kind === "pattern" ? (there ?? words.pattern) : lineLabel(state, of[0]!);
    const mirrored = of.some((shape) => shape.mirrored) ? [words.mirrored] : [];
    return { ...row("carried", itemKey.carried(item), label, of, words.from(onScan!.from), [...mirrored, words.carried]), kind: "carried" };
  });
}

function lesionRows({ drawn, stances }: Shown, row: RowOf): PlanRow[] {
  const circles = new Set(drawn.onScan?.patterns.shapes.flatMap(({ kind, item }) => (kind === "tumour" ? [item] : [])));
  const laid = (drawn.onScan?.plan.lesions ?? []).filter(({ id }) => !circles.has(id)); // a tumour by the clock whose depth is known has a row of its own
  const all = new Map<string, Pick<PlanLesion, "id" | "name" | "radius_mm">>([...drawn.lesions, ...laid].map((each) => [each.id, each]));
  return [...all.values()].map(({ id, name, radius_mm: radiusMm }): PlanRow => {
    const here = laid.find((each) => each.id === id) ?? null;
    const isComing = here === null && (stances.isCarrying || drawn.onScan === null);
    const outline = (here?.carried ? drawn.onScan?.carried : drawn.onScan?.patterns)?.shapes.filter((shape) => shape.item === id) ?? [];
    const sure = here === null ? [] : here.carried ? [...(here.error_mm === null ? [] : [marginOf(here.error_mm)]), words.carried] : [words.given];
    const says = here ? words.deep(here.depth_mm) : isComing ? words.busy : words.across(2 * radiusMm);
    return { ...row(here?.carried ? "carried" : "reference", itemKey.lesion(id), name, outline, says), hint: sure.join(", "), kind: "lesion", own: drawn.lesions.find((each) => each.id === id) ?? null, laid: here };
  });
}

/** The item whose numbers stand below the list: what is looked at or drawn, what was chosen, else the pattern. */
export function chosenRow(rows: readonly PlanRow[], { lesion, drawn, item }: Pick<Shown, "lesion" | "drawn" | "item">): PlanRow | null {
  const wanted = lesion !== null ? itemKey.lesion(lesion) : drawn.chosen !== null ? itemKey.line(drawn.chosen) : item;
  return rows.find(({ key }) => key === wanted) ?? (wanted === null ? (rows.find(({ kind }) => kind === "pattern") ?? null) : null);
}

/** What the service or the model's file calls a line; its name in words where that says no more than its name does. */
function lineLabel(state: Pick<Shown, "fit" | "models" | "meta">, { name, label = "", kind }: Shape): string {
  const said = label === name ? "" : label;
  if (kind === "line") return said === "" ? name : said;
  const onModel = (modelOf(state)?.side.drawings ?? []).flatMap(({ shapes }) => shapes).find((each) => each.name === name)?.label;
  return capital(said === "" ? (onModel ?? drawing.shapeName(name)) : said);
}

/** "both", "left" or "right": the sides on which lines of it are. */
function sidesSaid(shapes: readonly Shape[]): string {
  const sides = new Set(shapes.map(({ name }) => sideOf(name)));
  return sides.has("left") && sides.has("right") ? words.both : sides.has("left") ? words.sides.L : sides.has("right") ? words.sides.R : "";
}

const tumourLabel = (side: string | undefined, label = words.tumour): string => (side === "L" || side === "R" ? `${label}, ${words.breast[side]}` : label);
