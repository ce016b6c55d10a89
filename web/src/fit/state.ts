// A fit on the page: what was asked for, its iterations as they came, its result, and how the model is shown.
import type { DrawingFile, FitLinks, Iterated, Model, NodePose, Result, StanceChoice, Started } from "../api/types";
import type { Picks } from "../landmarks/picks";
import { hasLoose, type ScanSlice } from "../scan/state";
import type { PageSlice } from "../store/page";
import type { Triangles } from "../viewer/ply";
import type { ViewSlice } from "../viewer/state";
import type { ViewBarShown } from "../viewer/ViewBar";
import { levelOf } from "./verdict";

/** What a fit was asked for besides its landmarks; the drawing is the plan's, and follows without a fit. */
interface AskedSettings {
  readonly stance: StanceChoice;
  readonly preset: string;
  readonly refine: boolean;
}

export interface FitState {
  readonly id: string;
  readonly links: FitLinks;
  readonly state: "running" | "done" | "failed" | "cancelled";
  readonly started: Started | null;
  readonly iterations: readonly Iterated[];
  readonly shown: number; // index into iterations; -1 before the first
  readonly playing: boolean;
  readonly result: Result | null;
  readonly drawing: DrawingFile | null; // on the scan's surface
  readonly drawingName: string | null; // that a program asked this fit to draw; the page asks for none and shows the plan
  readonly surface: Triangles | null; // of fitted.ply, in the scan's unit
  readonly distances: Float32Array | null; // mm, of each vertex of the surface; NaN where there is no scan
  readonly reason: string | null;
  readonly isConnected: boolean;
  readonly picks: Picks | null; // that it was started with; null when it came from the address
  readonly certain: readonly string[]; // of those
  readonly asked?: AskedSettings; // of a fit whose settings the page knows
  readonly cuts?: string; // what was cut out of the scan by hand, see ScanState
  readonly predictedFrom?: string; // of a stance that was not scanned: the fit that it comes from
  readonly before: Result | null; // of the fit whose place it takes, which is shown until this one has its own
}

/** Nothing is known of it but its address. */
export const blankFit = (id: string, links: FitLinks): FitState => ({
  id,
  links,
  state: "running",
  started: null,
  iterations: [],
  shown: -1,
  playing: false,
  result: null,
  drawing: null,
  drawingName: null,
  surface: null,
  distances: null,
  reason: null,
  isConnected: true,
  picks: null,
  certain: [],
  before: null,
});

export interface FitSlice {
  readonly stance: StanceChoice;
  readonly preset: string;
  readonly drawing: string; // the pattern and the tumour that are planned on this scan, see requestedDrawing.ts
  readonly refine: boolean;
  readonly fit: FitState | null;
  readonly followed: { readonly fit: string; readonly nodes: readonly NodePose[] } | null; // where the model lies while a landmark is dragged
  readonly isStarting: boolean; // the request for a fit is under way
  readonly showDistances: boolean;
  readonly showMirror: boolean; // the left breast on the right one
}

export const initialFit: FitSlice = {
  stance: "auto",
  preset: "default",
  drawing: "",
  refine: true,
  fit: null,
  followed: null,
  isStarting: false,
  showDistances: false,
  showMirror: false,
};

export const isFitting = (state: Pick<FitSlice, "isStarting" | "fit">): boolean => state.isStarting || state.fit?.state === "running";

/** The iteration that is on the screen. */
export const shownIteration = (fit: FitState | null): Iterated | null => fit?.iterations[fit.shown] ?? null;

/** True when the last iteration is on the screen and there will be no other. */
export const isAtRest = (fit: FitState): boolean => fit.state !== "running" && fit.shown === fit.iterations.length - 1;

/** It found no body, or the service says that it cannot be used: nothing of it is shown, no model, no line and no number. */
export const isUnusable = ({ fit }: { readonly fit: Pick<FitState, "state" | "result"> | null }): boolean => fit?.state === "failed" || levelOf(fit?.result) === "unusable";

/** The model follows a landmark of this fit, or waits for the fit with the landmark where it is now. */
export const isFollowing = ({ fit, followed }: Pick<FitSlice, "fit" | "followed">): boolean => fit !== null && followed?.fit === fit.id && isAtRest(fit);

/** Of the model that the shown fit was made with; of the service's own without a fit. */
export const modelHash = ({ meta, fit }: Pick<FitSlice & PageSlice, "meta" | "fit">): string | null => fit?.started?.model_sha256 ?? fit?.result?.model.sha256 ?? meta?.model.sha256 ?? null;

/** That model, once it is here: a fit's parameters mean nothing to another one. */
export const modelOf = (state: Pick<FitSlice & PageSlice, "meta" | "models" | "fit">): Model | null => state.models[modelHash(state) ?? ""] ?? null;

/** How the rig stands on the screen: as it follows a landmark, else as in the shown iteration. */
export const shownPoses = (state: Pick<FitSlice, "fit" | "followed">): readonly NodePose[] | null =>
  isUnusable(state) ? null : isFollowing(state) ? state.followed!.nodes  : (shownIteration(state.fit)?.nodes ?? null);

/** What decides which surface stands for the model. */
export type Shown = Pick<FitSlice & PageSlice, "meta" | "fit" | "followed" | "models" | "showDistances">;

/** Something of the model is on the stage. */
export const hasModelShown = (state: Shown): boolean => (state.fit !== null && state.fit.shown >= 0 && !isUnusable(state)) || showsFittedSurface(state);

/** At rest the surface that the service wrote stands for the posed rig: coloured, or bent onto the skin beyond what a rig can show. */
export const showsFittedSurface = (state: Shown): boolean => !isFollowing(state) && !isUnusable(state) && hasFittedSurface(state);

/** Smooth modes are in the surface alone: no node of the rig has them. */
const hasModes = ({ iterations }: FitState): boolean => (iterations.at(-1)?.modes?.length ?? 0) > 0;

const hasFittedSurface = (state: Shown): boolean => {
  const { fit, showDistances } = state;
  return Boolean(fit?.surface && fit.result && isAtRest(fit) && (!modelOf(state) || fit.result.refined || hasModes(fit) || (showDistances && fit.distances)));
};

/** Scan and model are there, so that there is something to choose between. */
export const hasBoth = ({ scan, fit }: Pick<ScanSlice & FitSlice, "scan" | "fit">): boolean => scan !== null && fit !== null && !isUnusable({ fit });

/** What of the page's state the bar on the stage shows. */
export const viewBarShown = ({ scan, loading, fit, overlay, view, showDistances, showLoose, showRelief, showColours }: Pick<ViewSlice & ScanSlice & FitSlice, "scan" | "loading" | "fit" | "overlay" | "view" | "showDistances" | "showLoose" | "showRelief" | "showColours">): ViewBarShown => ({
  isShown: scan !== null && loading === null,
  view: view.name,
  hasOverlays: fit !== null && !isUnusable({ fit }) && scan?.mesh !== null,
  overlay,
  only: scan?.mesh === null ? "model" : "scan",
  looks: {
    ...(fit?.distances != null ? { distances: showDistances } : {}),
    ...(scan?.info.colours === "none" && scan.mesh !== null && overlay !== "model" ? { relief: showRelief } : {}),
    ...(hasLoose(scan) ? { loose: showLoose } : {}),
    ...(scan && scan.info.colours !== "none" && scan.mesh !== null ? { colours: showColours } : {}),
  },
});

/** The coloured surface alone: over the scan the two would fight for each pixel. */
export const withDistances = ({ overlay }: Pick<ViewSlice, "overlay">, showDistances: boolean) => ({
  showDistances,
  overlay: showDistances && (overlay === "both" || overlay === "scan") ? ("model" as const) : overlay,
});
