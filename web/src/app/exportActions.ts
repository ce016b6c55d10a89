// Files that the page makes itself: the picture of the view, and the distances as a table.
import { distancesCsv } from "../fit/distances/distances";
import type { FitSlice } from "../fit/state";
import { fileName, type ScanSlice } from "../scan/state";
import type { PageSlice } from "../store/page";
import { withProblem } from "../store/problems";
import type { Store } from "../store/store";
import { saveBlob, saveFile } from "../ui/dom";
import * as text from "./text";

export function exportActions(store: Store<PageSlice & ScanSlice & FitSlice>) {
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

    saveDistances: (): void => {
      const { scan, fit } = store.get();
      const distances = fit?.distances;
      if (scan && distances) saveFile(fileName(scan, text.files.distances, fit.result?.stance), distancesCsv(distances), "text/csv");
    },
  };
}

export type ExportActions = ReturnType<typeof exportActions>;
