// Files that the page makes itself: the picture of the view, and the distances as a table.
import { client } from "../api/client";
import { distancesCsv } from "../fit/distances/distances";
import { toText } from "../drawing/lines/files";
import type { DrawingSlice } from "../drawing/state";
import type { FitSlice } from "../fit/state";
import { fileName, type ScanSlice } from "../scan/state";
import type { PageSlice } from "../store/page";
import { messageOf, withProblem } from "../store/problems";
import type { Store } from "../store/store";
import { saveBlob, saveFile } from "../ui/dom";
import * as text from "./text";

export function exportActions(store: Store<PageSlice & ScanSlice & FitSlice & DrawingSlice>) {
  let take: (() => Promise<Blob>) | null = null;
  return {
    /** Set by the view: how a picture of it is taken; without WebGL there is none. */
    setPicture: (how: () => Promise<Blob>): void => void (take = how),

    async save(): Promise<void> {
      try {
        if (!take) throw new Error("no view");
        const { scan, fit } = store.get();
        saveBlob(scan ? fileName(scan, text.files.saveAs, fit?.result?.stance) : text.files.saveAs, await take());
      } catch {
        store.set((state) => withProblem(state, "page", text.files.failed));
      }
    },

    /** The lines that a hand has drawn on this scan. */
    saveLines: (): void => {
      const { scan, fit, drawn } = store.get();
      if (scan) saveFile(fileName(scan, text.files.lines, fit?.result?.stance), toText(drawn.lines.present, { patient: scan.info.patient_code, scans: [scan.info.sha256] }), "application/json");
    },

    /** A file that the service makes of the plan on this fit; why it cannot is said as the page's problem. */
    async saveOfPlan(kind: text.OfPlan): Promise<void> {
      const { fit } = store.get();
      if (!fit) return;
      try {
        const { name, blob } = await client.madeOfPlan(fit.links.report, text.files.ofPlan[kind]);
        saveBlob(name, blob);
      } catch (error) {
        store.set((state) => withProblem(state, "page", messageOf(error)));
      }
    },

    saveDistances: (): void => {
      const { scan, fit } = store.get();
      const distances = fit?.distances;
      if (scan && distances) saveFile(fileName(scan, text.files.distances, fit.result?.stance), distancesCsv(distances), "text/csv");
    },
  };
}
