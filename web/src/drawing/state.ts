// What is drawn on the page's scan, and what the hand does there.
import type { DrawingFile, PlannedShape, PlanOnScan, Unit, Vector } from "../api/types";
import { type History, startHistory } from "../store/history";
import { INK, type OwnLine } from "./lines";
import type { Asymmetry } from "./mirroredBreast";
import type { Tape } from "./tape";

export type Tool = "none" | "pen" | "points" | "tumour" | "tape" | "erase";
/** Beside the body; the full canvas has others. */
export const TOOLS: readonly Tool[] = ["none", "pen", "points", "tumour", "tape"];

/** Lines as the service has laid them on a scan, in its unit. */
export interface Laid {
  readonly unit: Unit;
  readonly shapes: readonly PlannedShape[];
}

/** The whole plan as the service has laid it on this scan. */
export interface OnScan {
  readonly from: string; // what the other stance is called
  readonly key: readonly unknown[]; // what it was made of; another one makes it old
  readonly plan: PlanOnScan;
  readonly patterns: Laid; // patterns and tumours that were made on this scan
  readonly carried: Laid; // everything that was made on the other one
}

export function laidOnScan(from: string, key: readonly unknown[], plan: PlanOnScan): OnScan {
  const { unit, shapes } = plan;
  const patterns = shapes.filter(({ kind, carried }) => !carried && kind !== "line");
  return { from, key, plan, patterns: { unit, shapes: patterns }, carried: { unit, shapes: shapes.filter(({ carried }) => carried) } };
}

/** What is shown of patterns and tumours: as the plan has them now, else as the fit brought them along. */
export const shownPatterns = ({ fit, drawn }: { readonly fit: { readonly drawing: DrawingFile | null } | null; readonly drawn: DrawnState }): DrawingFile | Laid | null =>
  drawn.onScan?.patterns ?? fit?.drawing ?? null;

/** What is drawn on one scan, and what the hand does there. */
export interface DrawnState {
  readonly lines: History<readonly OwnLine[]>;
  readonly saving: "saved" | "saving" | "unsaved";
  readonly tool: Tool;
  readonly start: Vector | null; // first click of a line that has no second one yet
  readonly open: string | null; // the line that the next click continues
  readonly chosen: string | null; // the line whose points are shown
  readonly corner: number | null; // which of its corners: index into corners
  readonly tape: Tape | null; // as it is laid now; it is never saved
  readonly radiusMm: number; // of the next tumour circle
  readonly ink: string; // #rrggbb, of the next line
  readonly note: string; // what the surgeon says about it in words
  readonly depthMm: number | null; // of the tumour by the clock, below the skin
  readonly hidden: ReadonlySet<string>; // layerKey of lines that are switched off
  readonly onScan: OnScan | null;
}

export type Layer = "reference" | "own" | "carried" | "band";
export const layerKey = (layer: Layer, name: string): string => `${layer}/${name}`;
/** The bands of all lines are switched as one. */
export const ALL_BANDS = "all";
export const BANDS = layerKey("band", ALL_BANDS);

export interface DrawingSlice {
  readonly drawn: DrawnState;
  readonly isCanvasFull: boolean; // the body alone, with floating tools
  readonly asymmetry: Asymmetry | null; // of the mirrored breast that was made last
}

export function startDrawn(lines: readonly OwnLine[] = [], words: Pick<DrawnState, "note" | "depthMm"> = { note: "", depthMm: null }): DrawnState {
  return {
    lines: startHistory(lines),
    saving: "saved",
    tool: "none",
    start: null,
    open: null,
    chosen: null,
    corner: null,
    tape: null,
    radiusMm: 15,
    ink: INK,
    note: words.note,
    depthMm: words.depthMm,
    hidden: new Set(),
    onScan: null,
  };
}

export const initialDrawing: DrawingSlice = { drawn: startDrawn(), isCanvasFull: false, asymmetry: null };

/** Without a scan to draw on, and in another step, there is no full canvas. */
export const withoutCanvas = <State extends Pick<DrawingSlice, "isCanvasFull"> & { readonly step: string; readonly scan: object | null }>(state: State): State =>
  state.isCanvasFull && (state.step !== "drawing" || state.scan === null) ? { ...state, isCanvasFull: false } : state;

/** With the tool put down and no line begun. */
export const handsOff = (drawn: DrawnState): DrawnState => ({ ...drawn, tool: "none", start: null, open: null, tape: null });

export const lineNamed = (state: DrawnState, name: string | null): OwnLine | null =>
  state.lines.present.find((line) => line.name === name) ?? null;
