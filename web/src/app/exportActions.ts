// Files that the page makes itself: the picture of the view, and the distances as a table.
import { saveBlob, saveFile } from "../ui/dom";
import { distancesCsv } from "../fit/distances";
import type { Session } from "./session";
import type { Store } from "../store/store";
import { text } from "../ui/text";
import { withProblem } from "../store/problems";

export function pictureActions(store: Store<Session>) {
  let take: (() => Promise<Blob>) | null = null;
  return {
    /** The view tells how a picture of it is taken; without WebGL there is none. */
    takenBy: (how: () => Promise<Blob>): void => void (take = how),

    async save(): Promise<void> {
      try {
        if (!take) throw new Error("no view");
        saveBlob(text.picture.saveAs, await take());
      } catch {
        store.set((state) => withProblem(state, "page", text.picture.failed));
      }
    },

    saveDistances(): void {
      const distances = store.get().fit?.distances;
      if (distances) saveFile(text.picture.distances, distancesCsv(distances), "text/csv");
    },
  };
}
