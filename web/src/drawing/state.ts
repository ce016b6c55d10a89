// What is drawn on the page's scan, and what the hand does there.
import type { DrawingFile, PatternHandle, PlanLesion, PlannedShape, PlanOnScan, Unit, Vector } from "../api/types";
import { type History, startHistory } from "../store/history";
import { INK, type OwnLine } from "./lines/lines";
import type { Asymmetry } from "./mirror/mirroredBreast";
import { initialSlices, type SlicesState } from "./slices/state";
import type { Tape } from "./tape/tape";

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

/** What is shown of patterns and tumours: as a hand drags them, as the plan has them now, else as the fit brought them along. */
export const shownPatterns = (state: { readonly fit: { readonly drawing: DrawingFile | null } | null; readonly drawn: DrawnState }): DrawingFile | Laid | null =>
  draggedPatterns(state.drawn) ?? laidPatterns(state);

/** The same but for what a hand drags. */
export const laidPatterns = ({ fit, drawn }: { readonly fit: { readonly drawing: DrawingFile | null } | null; readonly drawn: DrawnState }): DrawingFile | Laid | null =>
  drawn.onScan?.patterns ?? fit?.drawing ?? null;

/** Until the plan with the change has been laid on the scan. */
const draggedPatterns = ({ live, onScan }: DrawnState): Laid | null => (live?.dragged?.over === onScan ? live.dragged.patterns : null);

/** Which part of the drawing a handle belongs to, see fit/requestedDrawing.ts. */
export type LivePart = "values" | "tumour";

export interface LiveHandle extends PatternHandle {
  /** as the drawn lines measure, by parameter; not while a hand drags */
  readonly measured?: Readonly<Record<string, number>>;
  readonly id: string;
  readonly part: LivePart;
}

/** Patterns with their handles, as the service draws them while one is dragged. */
export interface Live {
  readonly key: string; // what the handles are of
  readonly handles: readonly LiveHandle[];
  readonly held: string | null; // id of the handle in the hand
  readonly values: Readonly<Record<string, string>> | null; // of the held part, as they are now
  readonly limit: string; // why the drag goes no farther
  readonly dragged: { readonly patterns: Laid; readonly over: OnScan | null } | null;
}

/** What a person has decided about lines of ink that were found on the skin, by the service's names for them. */
export type InkDecided = Readonly<Record<string, "accepted" | "dropped">>;

/** Everything of the plan that belongs to one scan, as one step of undoing puts it back. */
export interface PlanStep {
  readonly lines: readonly OwnLine[];
  readonly drawing: string; // patterns and tumour, see fit/requestedDrawing.ts
  readonly note: string;
  readonly depthMm: number | null;
  readonly lesions: readonly PlanLesion[];
  readonly decided?: InkDecided | null; // left out or null: it is not known, and stays as it is
}

export type PlanHistory = History<readonly OwnLine[], PlanStep>;

const STEPS = 200; // far more than anybody undoes

export const stepOf = ({ drawing, drawn }: { readonly drawing: string; readonly drawn: DrawnState }): PlanStep => ({ lines: drawn.lines.present, drawing, note: drawn.note, depthMm: drawn.depthMm, lesions: drawn.lesions, decided: drawn.decided });

/** The history with what is there now as its last step, before something changes. */
export const withStep = (state: { readonly drawing: string; readonly drawn: DrawnState }): PlanHistory => ({
  past: [...state.drawn.lines.past, stepOf(state)].slice(-STEPS),
  present: state.drawn.lines.present,
  future: [],
});

/** What is drawn on one scan, and what the hand does there. */
interface AnotherDrawing {
  readonly theirs: string | null; // code of the patient that the file names
  readonly ours: string;
  readonly lines: readonly OwnLine[];
}

export interface DrawnState {
  readonly lines: PlanHistory; // of lines, patterns, tumour and words
  readonly saving: "saved" | "saving" | "unsaved"; // of all that is planned on the scan
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
  readonly lesions: readonly PlanLesion[]; // inside the body, as an image showed them
  readonly decided: InkDecided | null; // null before ink was looked for
  readonly hidden: ReadonlySet<string>; // layerKey of lines that are switched off
  readonly onScan: OnScan | null;
  readonly live: Live | null;
  readonly another: AnotherDrawing | null; // a file of another patient, not taken before somebody says so
  readonly isChangedElsewhere: boolean; // somebody else has written the plan since it was read
  readonly contested: Pick<PlanStep, "drawing" | "depthMm"> | null; // as they were changed elsewhere while they were changed here in another way
}

export type Layer = "reference" | "own" | "carried";
export const layerKey = (layer: Layer, name: string): string => `${layer}/${name}`;

export interface DrawingSlice {
  readonly drawn: DrawnState;
  readonly isCanvasFull: boolean; // the body alone, with floating tools
  readonly lesion: string | null; // id of the one that is looked at, through the skin
  readonly item: string | null; // of the plan: whose numbers are shown where no line and no lesion is chosen, see panel/items.ts; empty for none
  readonly slices: SlicesState;
  readonly asymmetry: Asymmetry | null; // of the mirrored breast that was made last
  readonly hasPen: boolean; // one was seen on this page: fingers turn the body
  readonly fingersDraw: boolean; // all the same
}

type Words = Pick<DrawnState, "note" | "depthMm" | "lesions"> & Partial<Pick<DrawnState, "contested" | "saving">>;

export function startDrawn(lines: readonly OwnLine[] = [], words: Words = { note: "", depthMm: null, lesions: [] }): DrawnState {
  return {
    lines: startHistory(lines),
    saving: words.saving ?? "saved",
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
    lesions: words.lesions,
    decided: null,
    hidden: new Set(),
    onScan: null,
    live: null,
    another: null,
    isChangedElsewhere: false,
    contested: words.contested ?? null,
  };
}

export const initialDrawing: DrawingSlice = { drawn: startDrawn(), isCanvasFull: false, lesion: null, item: null, slices: initialSlices, asymmetry: null, hasPen: false, fingersDraw: false };

/** Without a scan to draw on, and in another step, there is no full canvas. */
export const withoutCanvas = <State extends Pick<DrawingSlice, "isCanvasFull"> & { readonly step: string; readonly scan: object | null }>(state: State): State =>
  state.isCanvasFull && (state.step !== "plan" || state.scan === null) ? { ...state, isCanvasFull: false } : state;

/** With the tool put down and no line begun. */
export const handsOff = (drawn: DrawnState): DrawnState => ({ ...drawn, tool: "none", start: null, open: null, tape: null, live: null });

export const lineNamed = (state: DrawnState, name: string | null): OwnLine | null =>
  state.lines.present.find((line) => line.name === name) ?? null;
