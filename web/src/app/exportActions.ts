// Files that the page makes itself: the picture of the view, and the distances as a table.
import { distancesCsv } from "../fit/distances/distances";
import type { FitSlice } from "../fit/state";
import type { PageSlice } from "../store/page";
import { withProblem } from "../store/problems";
import type { Store } from "../store/store";
import { saveBlob, saveFile } from "../ui/dom";
import * as text from "./text";

export function exportActions(store: Store<PageSlice & FitSlice>) {
  let take: (() => Promise<Blob>) | null = null;
  return {
    /** Set by the view: how a picture of it is taken; without WebGL there is none. */
    setPicture: (how: () => Promise<Blob>): void => void (take = how),

    async save(): Promise<void> {
      try {
        if (!take) throw new Error("no view");
        saveBlob(text.files.saveAs, await take());
      } catch {
        store.set((state) => withProblem(state, "page", text.files.failed));
      }
    },

    saveDistances: (): void => {
      const distances = store.get().fit?.distances;
      if (distances) saveFile(text.files.distances, distancesCsv(distances), "text/csv");
    },
  };
}

export type ExportActions = ReturnType<typeof exportActions>;
