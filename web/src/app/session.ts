// The whole state of the page as one type, and how it starts.
import type {
  DrawingFile,
  Example,
  FitLinks,
  Frame,
  Iterated,
  LandmarkFile,
  Meta,
  ModelSide,
  NodePose,
  Result,
  Scan,
  Share,
  StanceChoice,
  Started,
  UnitChoice,
} from "../api/types";
import { type DrawnState, startDrawn } from "../drawing/lines";
import { initialStances, type StancesState } from "../stances/state";
import { type History, startHistory } from "../store/history";
import type { Picks } from "../landmarks/picks";
import type { Look } from "../fit/handPose";
import type { Proposals } from "../landmarks/proposals";

export type Step = "scan" | "landmarks" | "fit" | "drawing" | "result";
export type Overlay = "scan" | "both" | "model" | "beside" | "swipe";
export const OVERLAYS: readonly Overlay[] = ["scan", "both", "model", "beside", "swipe"];
export type ViewName = "front" | "left" | "right" | "back" | "top";
export type Theme = "system" | "light" | "dark";

/** Where on the page something can go wrong: the message is shown there. */
export type Place = "service" | "scan" | "landmarks" | "fit" | "model" | "distances" | "drawing" | "stances" | "share" | "page";

export interface ScanState {
  readonly info: Scan;
  readonly title: string;
  readonly mesh: ArrayBuffer | null; // glTF binary, metres, the scan's own axes; null behind a link that does not show it
  readonly frame: Frame;
  readonly frameFrom: "service" | "landmarks" | "person"; // who says so; the last of these wins
  readonly file: File | null; // kept, so that another unit needs no second choosing
  readonly example: LandmarkFile | null;
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
  readonly drawingName: string | null;
  readonly surface: ArrayBuffer | null; // fitted.ply
  readonly distances: Float32Array | null; // mm, of each vertex of the surface; NaN where there is no scan
  readonly reason: string | null;
  readonly isConnected: boolean;
  readonly picks: Picks | null; // that it was started with; null when it came from the address
}

export interface Session {
  readonly meta: Meta | null;
  readonly examples: readonly Example[];
  readonly model: { readonly glb: ArrayBuffer; readonly side: ModelSide } | null;
  readonly step: Step;
  readonly loading: { readonly phase: "sending" | "preparing"; readonly share: number; readonly title: string } | null;
  readonly scan: ScanState | null;
  readonly confirmed: string | null; // the scan whose size and direction a person has called right
  readonly showColours: boolean;
  readonly picks: History<Picks>;
  readonly drawn: DrawnState;
  readonly proposals: Proposals | null; // null until somebody asked
  readonly skipped: ReadonlySet<string>;
  readonly active: string | null; // the landmark that the next click places
  readonly saving: "saved" | "saving" | "unsaved";
  readonly units: UnitChoice;
  readonly stance: StanceChoice;
  readonly preset: string;
  readonly drawing: string;
  readonly refine: boolean;
  readonly fit: FitState | null;
  readonly look: Look | null; // the model posed by hand
  readonly isStarting: boolean; // the request for a fit is under way
  readonly overlay: Overlay;
  readonly swipe: number; // 0 to 1: how much of the stage shows the scan
  readonly showDistances: boolean;
  readonly view: { readonly name: ViewName; readonly asked: number };
  readonly theme: Theme;
  readonly graphics: "ok" | "absent" | "lost";
  readonly share: {
    readonly isOpen: boolean;
    readonly isBusy: boolean;
    readonly list: readonly Share[] | null; // null until the service told
    readonly made: string | null; // address of the link just made: it is told only once
  };
  readonly stances: StancesState;
  readonly isSignedIn: boolean; // with a token; a service on one's own machine needs none
  readonly isHelpOpen: boolean;
  readonly problems: Readonly<Partial<Record<Place, string>>>;
  readonly announcement: string; // for the live region
}

export const initialSession: Session = {
  meta: null,
  examples: [],
  model: null,
  step: "scan",
  loading: null,
  scan: null,
  confirmed: null,
  showColours: true,
  picks: startHistory<Picks>({}),
  drawn: startDrawn(),
  proposals: null,
  skipped: new Set(),
  active: null,
  saving: "saved",
  units: "auto",
  stance: "auto",
  preset: "default",
  drawing: "lumpectomy",
  refine: false,
  fit: null,
  look: null,
  isStarting: false,
  overlay: "both",
  swipe: 0.5,
  showDistances: false,
  view: { name: "front", asked: 0 },
  theme: "system",
  graphics: "ok",
  share: { isOpen: false, isBusy: false, list: null, made: null },
  stances: initialStances,
  isSignedIn: false,
  isHelpOpen: false,
  problems: {},
  announcement: "",
};

export const isFitting = (state: Session): boolean => state.isStarting || state.fit?.state === "running";

/** Nobody has said yet that a scan of one's own has the right size and stands the right way up. */
export const needsConfirming = ({ scan, confirmed, picks }: Session): boolean =>
  scan !== null && scan.file !== null && confirmed !== scan.info.id && Object.keys(picks.present).length === 0;

/** The iteration that is on the screen. */
export const shownIteration = (fit: FitState | null): Iterated | null => fit?.iterations[fit.shown] ?? null;

/** True when the last iteration is on the screen and there will be no other. */
export const isAtRest = (fit: FitState): boolean => fit.state !== "running" && fit.shown === fit.iterations.length - 1;

/** Somebody has posed this fit's model by hand, and sees it so. */
export const hasLook = ({ fit, look }: Session): boolean => fit !== null && look?.fit === fit.id && isAtRest(fit);

/** How the rig stands on the screen: as posed by hand, else as in the shown iteration. */
export const shownPoses = (state: Session): readonly NodePose[] | null =>
  hasLook(state) ? state.look!.nodes : (shownIteration(state.fit)?.nodes ?? null);

/** Something of the model is on the stage. */
export const hasModelShown = (state: Session): boolean => (state.fit !== null && state.fit.shown >= 0) || showsFittedSurface(state);

/** Scan and model each have a part of the stage. */
export const isBeside = (overlay: Overlay): boolean => overlay === "beside" || overlay === "swipe";

/** At rest the surface that the service wrote stands for the posed rig: coloured, or bent onto the skin beyond what a rig can show. */
export const showsFittedSurface = (state: Session): boolean => !hasLook(state) && hasFittedSurface(state);

const hasFittedSurface = ({ fit, model, showDistances }: Session): boolean =>
  Boolean(fit?.surface && fit.result && isAtRest(fit) && (!model || fit.result.refined || (showDistances && fit.distances)));

export const pickCount = (state: Session): number => Object.keys(state.picks.present).length;
