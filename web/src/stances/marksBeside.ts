// Marks of the other scan: on this one they are expected where its fitted model has the same point of the skin.
import type { Vector } from "../api/types";
import type { FitState } from "../fit/state";
import type { Beside, MarksSlice } from "../landmarks/marks/marks";
import { isMark, markCalled } from "../landmarks/picks";
import { only, type Store } from "../store/store";
import { mmFrom } from "../ui/units";
import { scannedOther, type StancesSlice, type Workspace } from "./state";

type Shown = Pick<Workspace & StancesSlice, "fit" | "stances">;

/** mm, scan's axes. */
function placeOn({ surface, result }: FitState, face: number, weights: Vector): Vector | null {
  const unit = result?.scan.unit;
  if (!surface || unit === undefined || 3 * face + 2 >= surface.corners.length) return null;
  const corners = [0, 1, 2].map((corner) => surface.corners[3 * face + corner]!);
  return [0, 1, 2].map((axis) => mmFrom(corners.reduce((sum, vertex, k) => sum + weights[k]! * surface.places[3 * vertex + axis]!, 0), unit)) as Vector;
}

export function marksBeside({ fit, stances }: Shown): Beside {
  const other = scannedOther(stances);
  const known = other?.fit?.result?.marks ?? {};
  const place = (name: string): Vector | null => {
    const at = known[markCalled(name)];
    return at && fit ? placeOn(fit, at.face, at.barycentric) : null;
  };
  return Object.fromEntries(Object.keys(other?.picks.present ?? {}).filter(isMark).map((name) => [name, place(name)]));
}

export function followMarks(store: Store<Shown & MarksSlice>): void {
  store.select(only("fit", "stances"), (state, before) => {
    if (state.fit?.surface === before.fit?.surface && state.fit?.result === before.fit?.result && state.stances.other === before.stances.other) return;
    queueMicrotask(() => {
      const beside = marksBeside(store.get());
      if (JSON.stringify(beside) !== JSON.stringify(store.get().beside)) store.set({ beside });
    });
  });
}
