// Two stances of one patient: the page works on one, the other one waits with all that belongs to it.
import type { MeasuresFile, Patient, ScanVisit, Stance, VisitsFile } from "../api/types";
import { type DrawingSlice, handsOff, startDrawn } from "../drawing/state";
import type { FitSlice, FitState } from "../fit/state";
import type { LandmarksSlice } from "../landmarks/state";
import { isVolume, type ScanSlice } from "../scan/state";
import { inStance } from "../scan/text";
import { startHistory } from "../store/history";
import type { PageSlice } from "../store/page";
import type { ViewSlice } from "../viewer/state";
import * as text from "./text";

/** What belongs to one scan, and goes away and comes back with it. */
export type Workspace = Pick<
  ScanSlice & LandmarksSlice & FitSlice & DrawingSlice,
  "scan" | "picks" | "certain" | "proposals" | "skipped" | "saving" | "stance" | "drawing" | "fit" | "drawn"
>;

export type PatientScan = Patient["scans"][number];

/** Of the page's scan, or of the one that waits, and another one of the patient's. */
export interface AskedPair {
  readonly scan: string;
  readonly other: string;
  readonly says: string;
}

export const isSamePair = (one: AskedPair, other: AskedPair): boolean => [one.scan, one.other].every((id) => id === other.scan || id === other.other);

export interface VisitsState {
  readonly isOpen: boolean;
  readonly isBusy: boolean;
  readonly days: readonly ScanVisit[] | null; // of all scans; null: not asked for yet
  readonly file: VisitsFile | null;
}

export interface StancesState {
  readonly other: Workspace | null;
  readonly isSecond: boolean; // the page works on the one that came second: it stands to the right
  readonly isComparing: boolean;
  readonly isLinked: boolean; // turning one turns the other
  readonly isAdding: boolean; // the dialog for a second scan is open
  readonly isBringing: boolean; // the second scan is on its way
  readonly scans: readonly PatientScan[]; // all of the patient's
  readonly named: Patient | null; // another patient, whose code was typed: those scans are offered, if they are of the same patient
  readonly isCarrying: boolean;
  readonly asked: readonly AskedPair[]; // scans that do not look like one patient's: nothing is carried between them before the answer
  readonly unanswered: readonly AskedPair[]; // of those, about which a person cannot say: nothing is carried, and the plan's panel asks again when it is wanted
  readonly answers: number; // so many were given here
  readonly predicting: Stance | null; // the one that is being predicted
  readonly measures: { readonly isOpen: boolean; readonly isBusy: boolean; readonly of: string; readonly file: MeasuresFile | null; readonly pointed: string | null }; // pointed: at this row, measureKey
  readonly visits: VisitsState;
}

export interface StancesSlice {
  readonly stances: StancesState;
}

type Stances = Workspace & StancesSlice;

export const initialStances: StancesState = {
  other: null,
  isSecond: false,
  isComparing: false,
  isLinked: true,
  isAdding: false,
  isBringing: false,
  scans: [],
  named: null,
  isCarrying: false,
  asked: [],
  unanswered: [],
  answers: 0,
  predicting: null,
  measures: { isOpen: false, isBusy: false, of: "", file: null, pointed: null },
  visits: { isOpen: false, isBusy: false, days: null, file: null },
};

/** What the page has of its scan, as it may wait: a replay is at its end. */
export function workspaceOf({ scan, picks, certain, drawn, proposals, skipped, saving, stance, drawing, fit }: Workspace): Workspace {
  const resting = fit && { ...fit, shown: fit.iterations.length - 1, playing: false };
  return { scan, picks, certain, drawn: { ...handsOff(drawn), corner: null }, proposals, skipped, saving, stance, drawing, fit: resting };
}

/** Beside a scan: its prediction in another stance.  It has no skin of a scan, and nothing is made on it: all of the plan is carried there. */
export function predictedOf(from: Workspace, fit: FitState): Workspace {
  return { ...from, scan: from.scan && { ...from.scan, mesh: null }, picks: startHistory({}), certain: {}, proposals: null, skipped: new Set(), stance: "auto", drawing: "", drawn: startDrawn(), fit: { ...fit, distances: null } };
}

export const isPredicted = ({ fit }: Pick<Workspace, "fit">): boolean => fit?.predictedFrom !== undefined;

/** The stance that waits, if a scan shows it. */
export const scannedOther = ({ other }: Pick<StancesState, "other">): Workspace | null => (other && !isPredicted(other) ? other : null);

/** standing, supine or prone: as fitted, as asked for, or as the service proposes. */
export function stanceOf(workspace: Pick<Workspace, "fit" | "stance" | "scan">): "standing" | "supine" | "prone" {
  const asked = workspace.stance === "auto" ? null : workspace.stance;
  return workspace.fit?.result?.stance ?? asked ?? workspace.scan?.info.stance.proposed ?? "standing";
}

/** The stances that no scan of the patient shows, of whom the one in work is one. */
export function unscanned(state: Pick<Stances, "scan" | "stance" | "fit" | "stances">): readonly Stance[] {
  const other = scannedOther(state.stances);
  const seen = new Set<Stance>([stanceOf(state), ...(other ? [stanceOf(other)] : []), ...state.stances.scans.filter(({ id }) => id !== state.scan?.info.id && id !== other?.scan?.info.id).map(({ stance }) => stance)]);
  return (["standing", "supine", "prone"] as const).filter((stance) => !seen.has(stance));
}

/** What the two are called, the one that the page works on first; two of a kind are numbered as they stand. */
export function stanceNames(state: Pick<Stances, "scan" | "stance" | "fit" | "stances">): [string, string] {
  const { other, isSecond } = state.stances;
  const [mine, its] = [inStance(stanceOf(state)), other ? text.stances.called(inStance(stanceOf(other)), isPredicted(other)) : ""];
  if (mine !== its) return [mine, its];
  return isSecond ? [`${mine} 2`, `${its} 1`] : [`${mine} 1`, `${its} 2`];
}

/** The fits to measure: the first that came, and the second one when it is done as well. */
export function measuredFits({ fit, stances }: Pick<Stances, "fit" | "stances">): [FitState, FitState | null] | null {
  if (fit?.state !== "done") return null;
  const its = stances.other?.fit?.state === "done" ? stances.other.fit : null;
  return its && stances.isSecond ? [its, fit] : [fit, its];
}

/** A scan that is an image's, or its label map. */
export const isImage = ({ scan }: Pick<Workspace, "scan">): boolean => scan !== null && isVolume(scan.info);

/** There is something inside the body to look at. */
export const hasInside = (state: Pick<Stances, "scan" | "drawn" | "stances">): boolean =>
  [state, scannedOther(state.stances)].some((each) => each !== null && (isImage(each) || each.drawn.lesions.length + (each.drawn.onScan?.plan.lesions.length ?? 0) > 0));

/** Both stances are on the stage.  While landmarks are placed there is one, with its instructions. */
export const isComparing = (state: Pick<ScanSlice & LandmarksSlice & StancesSlice, "scan" | "active" | "stances"> ): boolean =>
  state.stances.isComparing && state.stances.other !== null && state.scan !== null && state.active === null;

/** The state as the other pane shows it. */
export function otherState<State extends Pick<PageSlice & ViewSlice & LandmarksSlice & StancesSlice, "step" | "overlay" | "active" | "stances">>(state: State): (State & Workspace) | null {
  const { other } = state.stances;
  if (!other) return null;
  const overlay = isPredicted(other) ? "model"  : state.overlay;
  return { ...state, ...other, overlay, active: null, step: state.step === "plan" ? "plan" : "handover" };
}

/** A fit that is over but not all here, or that was running when its scan was put aside. */
export const isUnfinished = (fit: FitState | null): boolean =>
  fit !== null && (fit.state === "running" || (fit.state === "done" && (fit.surface === null || (fit.drawingName !== null && fit.drawing === null))));
