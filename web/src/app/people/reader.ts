// For a person who may look only: what would change something says so instead.  The service refuses it too.
import { mayPlan } from "../../store/person";
import type { PageSlice } from "../../store/page";
import { withProblem } from "../../store/problems";
import type { Store } from "../../store/store";
import { people as words } from "./text";

export const CHANGES = {
  bring: ["files", "begin", "again", "takeSegments", "examples", "sizeIsRight"],
  scan: ["upload", "takeExample", "add", "addLesions", "readAgain", "confirmModel", "takeLasso", "crop", "bringBack", "uncrop", "undoCrop", "redoCrop"],
  deletion: ["ask"],
  landmarks: [
    "place", "move", "want", "wantNext", "addMark", "adopt", "renameMark", "confirm", "confirmWanted", "keep", "unkeep", "check", "takeOut", "exchange", "restore", "remove",
    "undo", "redo", "useExample", "importFile",
  ],
  size: ["measure", "apply", "remove", "undo", "redo"],
  body: ["undo", "redo"],
  drawing: [
    "click", "strokes", "fullCanvas", "moveLesion", "markLesion", "recolour", "cutTo", "choosePattern", "close", "mirror", "tumour", "radius", "rename", "erase", "adopt", "decide",
    "restore", "moveCorner", "addCorner", "removeCorner", "undo", "undoKept", "redo", "tidy", "importFile", "takeAnother",
  ],
  plan: ["takeOver", "settle", "note", "depth", "lesions"],
  stances: ["dialog", "name", "upload", "takeExample", "takeExampleBeside", "takeKnown", "remove", "fitBoth", "predict", "samePatient"],
  checks: ["begin", "yes", "unseen", "move", "keep", "takeOut", "exchange", "stance"],
  patients: ["rename", "remove", "give"],
  visits: ["say"],
  share: ["open", "make", "unlock", "refresh", "revoke"],
  fit: ["start", "refit", "cancel", "chooseStance", "choosePreset", "chooseRefine"],
} as const;

/** The same actions; each that changes something first looks whether the person may. */
export function forPerson<Actions extends Readonly<Record<keyof typeof CHANGES, object>>>(actions: Actions, store: Store<PageSlice>): Actions {
  const refuse = (): void => store.set((state) => ({ announcement: said(state), ...withProblem(state, "page", said(state)) }));
  const guarded = (room: object, names: readonly string[]): object =>
    Object.fromEntries(
      Object.entries(room).map(([name, action]) => [
        name,
        names.includes(name) ? (...given: unknown[]): unknown => (mayPlan(store.get()) ? (action as (...all: unknown[]) => unknown).apply(room, given) : refuse()) : action,
      ]),
    );
  const rooms = Object.entries(CHANGES).map(([room, names]) => [room, guarded(actions[room as keyof typeof CHANGES], names)]);
  return { ...actions, ...(Object.fromEntries(rooms) as Partial<Actions>) };
}

const said = ({ meta }: Pick<PageSlice, "meta">): string => words.mayLook(meta?.person?.name ?? "");
