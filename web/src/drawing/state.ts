// What is drawn on the page's scan, and what the hand does there.
import type { CarriedDrawing, Vector } from "../api/types";
import { type History, startHistory } from "../store/history";
import type { OwnLine } from "./lines";

export type Tool = "none" | "pen" | "points" | "tumour";
export const TOOLS: readonly Tool[] = ["none", "pen", "points", "tumour"];

/** A drawing of the other stance, as the service carried it to this scan. */
export interface Carried {
  readonly from: string; // what the other stance is called
  readonly fromFit: string;
  readonly toFit: string;
  readonly source: readonly OwnLine[]; // that it was made of; another one makes it old
  readonly drawing: CarriedDrawing;
}

/** What is drawn on one scan, and what the hand does there. */
export interface DrawnState {
  readonly lines: History<readonly OwnLine[]>;
  readonly saving: "saved" | "saving" | "unsaved";
  readonly tool: Tool;
  readonly start: Vector | null; // first click of a line that has no second one yet
  readonly open: string | null; // the line that the next click continues
  readonly chosen: string | null; // the line whose points are shown
  readonly corner: number | null; // which of its corners: index into corners
  readonly radiusMm: number; // of the next tumour circle
  readonly hidden: ReadonlySet<string>; // layerKey of lines that are switched off
  readonly carried: Carried | null;
}

export type Layer = "reference" | "own" | "carried" | "band";
export const layerKey = (layer: Layer, name: string): string => `${layer}/${name}`;
/** The bands of all lines are switched as one. */
export const ALL_BANDS = "all";
export const BANDS = layerKey("band", ALL_BANDS);

export interface DrawingSlice {
  readonly drawn: DrawnState;
}

export function startDrawn(lines: readonly OwnLine[] = []): DrawnState {
  return {
    lines: startHistory(lines),
    saving: "saved",
    tool: "none",
    start: null,
    open: null,
    chosen: null,
    corner: null,
    radiusMm: 15,
    hidden: new Set(),
    carried: null,
  };
}

export const initialDrawing: DrawingSlice = { drawn: startDrawn() };

/** With the tool put down and no line begun. */
export const handsOff = (drawn: DrawnState): DrawnState => ({ ...drawn, tool: "none", start: null, open: null });

export const lineNamed = (state: DrawnState, name: string | null): OwnLine | null =>
  state.lines.present.find((line) => line.name === name) ?? null;
