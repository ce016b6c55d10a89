// The whole state of the page: the parts of its features put together.
import type { Frame, Scan } from "../api/types";
import { type ChecksSlice, initialChecks } from "../checks/state";
import { type DrawingSlice, initialDrawing } from "../drawing/state";
import { type FitSlice, initialFit } from "../fit/state";
import { initialInk, type InkSlice } from "../ink/state";
import { initialMarks, type MarksSlice } from "../landmarks/marks/marks";
import { initialRuler, initialSizes, type RulerSlice, type SizesSlice } from "../landmarks/size/ruler";
import { type LandmarksSlice, startLandmarks } from "../landmarks/state";
import { initialScan, type ScanSlice } from "../scan/state";
import { initialPatients, type PatientsSlice } from "../patients/state";
import { initialShare, type ShareSlice } from "../share/state";
import { type FoundSlice, initialFound } from "../stances/found/state";
import { initialStances, type StancesSlice } from "../stances/state";
import type { Unsaved } from "../store/outbox";
import { initialPage, type PageSlice } from "../store/page";
import { initialView, type ViewSlice } from "../viewer/state";

/** A scan that will be deleted unless the person takes it back. */
export interface Deletion {
  readonly scan: Scan;
  readonly title: string;
  readonly fit: string | null;
  readonly frame: Frame | null; // as a person has turned it
  readonly beside: { readonly scan: string; readonly isSecond: boolean } | null; // the stance that stays on the page, and whether it came second
}

export interface Session extends PageSlice, ViewSlice, ScanSlice, LandmarksSlice, MarksSlice, RulerSlice, SizesSlice, FitSlice, DrawingSlice, StancesSlice, FoundSlice, ChecksSlice, InkSlice, PatientsSlice, ShareSlice {
  readonly isSignedIn: boolean; // with a token; a service on one's own machine needs none
  readonly isHelpOpen: boolean;
  readonly fitsAtOnce: boolean; // new scans are fitted by themselves
  readonly leaving: readonly Unsaved[] | null; // asked: may they be lost?
  readonly isAskingToDelete: boolean;
  readonly deletion: Deletion | null; // the service does not know of it yet
  readonly overlayBefore: Session["overlay"] | null; // what was shown before something was placed
}

export const initialSession: Session = {
  ...initialPage,
  ...initialView,
  ...initialScan,
  ...startLandmarks(),
  ...initialMarks,
  ...initialRuler,
  ...initialSizes,
  ...initialFit,
  ...initialDrawing,
  stances: initialStances,
  ...initialFound,
  checks: initialChecks,
  ...initialInk,
  patients: initialPatients,
  ...initialShare,
  isSignedIn: false,
  isHelpOpen: false,
  fitsAtOnce: true,
  leaving: null,
  isAskingToDelete: false,
  deletion: null,
  overlayBefore: null,
};
