// The state of a visitor's page: what shows a result, and nothing that changes one.
import type { PlanOnScan } from "../../api/types";
import { type DrawingSlice, initialDrawing } from "../../drawing/state";
import { type FitSlice, initialFit } from "../../fit/state";
import { initialScan, type ScanSlice } from "../../scan/state";
import { initialPage, type PageSlice } from "../../store/page";
import { initialView, type ViewSlice } from "../../viewer/state";

export interface VisitorState extends PageSlice, ViewSlice, ScanSlice, FitSlice, DrawingSlice {
  readonly plan: PlanOnScan | null; // null before the link is open
}

export const initialVisitor: VisitorState = { ...initialPage, ...initialView, ...initialScan, ...initialFit, ...initialDrawing, plan: null };
