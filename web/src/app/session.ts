// The whole state of the page: the parts of its features put together.
import { type DrawingSlice, initialDrawing } from "../drawing/state";
import { type FitSlice, initialFit } from "../fit/state";
import { type LandmarksSlice, startLandmarks } from "../landmarks/state";
import { initialScan, type ScanSlice } from "../scan/state";
import { initialShare, type ShareSlice } from "../share/state";
import { initialStances, type StancesSlice } from "../stances/state";
import { initialPage, type PageSlice } from "../store/page";
import { initialView, type ViewSlice } from "../viewer/state";

export interface Session extends PageSlice, ViewSlice, ScanSlice, LandmarksSlice, FitSlice, DrawingSlice, StancesSlice, ShareSlice {
  readonly isSignedIn: boolean; // with a token; a service on one's own machine needs none
  readonly isHelpOpen: boolean;
  readonly overlayBefore: Session["overlay"] | null; // what was shown before something was placed
}

export const initialSession: Session = {
  ...initialPage,
  ...initialView,
  ...initialScan,
  ...startLandmarks(),
  ...initialFit,
  ...initialDrawing,
  stances: initialStances,
  ...initialShare,
  isSignedIn: false,
  isHelpOpen: false,
  overlayBefore: null,
};
