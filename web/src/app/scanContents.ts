// What the page keeps with a scan besides the scan itself: landmarks, drawing, fit.  Read when a scan is opened, dropped
// when it is left.
import { startDrawn } from "../drawing/state";
import type { LandmarkActions } from "../landmarks/actions";
import { initialRuler } from "../landmarks/size/ruler";
import { startLandmarks } from "../landmarks/state";
import { standing } from "../landmarks/straighten";
import type { ScanContents } from "../scan/actions";
import type { PlanActions } from "../plan/actions";
import { initialStances } from "../stances/state";
import { startHistory } from "../store/history";
import type { Session } from "./session";

export function scanContents(landmarks: Pick<LandmarkActions, "read">, plan: Pick<PlanActions, "read">, stop: () => void): ScanContents {
  return {
    async read(info) {
      const [saved, { lines, drawing, ...words }] = await Promise.all([landmarks.read(info).catch(() => null), plan.read(info)]);
      const picks = saved?.picks ?? {};
      const state: Partial<Session> = { ...startLandmarks(picks, saved?.certain, saved?.saving), ...initialRuler, drawn: startDrawn(lines, words), drawing, fit: null, isStarting: false, stance: "auto" };
      return { state, stands: standing(info.frame, picks) };
    },
    none: (): Partial<Session> => ({
      picks: startHistory({}),
      certain: {},
      proposals: null,
      active: null,
      ...initialRuler,
      drawn: startDrawn(),
      fit: null,
      isStarting: false,
      stances: initialStances,
    }),
    cut: (): Partial<Session> => ({ proposals: null }),
    interrupted: (): Partial<Session> => ({ active: null }),
    stop,
  };
}
