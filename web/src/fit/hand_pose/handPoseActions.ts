// Moves the shown model by hand and puts it back; the fit itself stays what it is.
import type { NodePose } from "../../api/types";
import type { PageSlice } from "../../store/page";
import type { Store } from "../../store/store";
import type { ViewSlice } from "../../viewer/state";
import { type Axis, withScale, withWeight } from "./handPose";
import { type FitSlice, isAtRest, shownPoses } from "../state";

type State = PageSlice & ViewSlice & FitSlice;

export function handPoseActions(store: Store<State>) {
  function change(move: (nodes: readonly NodePose[]) => NodePose[]): void {
    const state = store.get();
    const nodes = shownPoses(state);
    if (!state.fit || !nodes || !isAtRest(state.fit)) return;
    // Over the scan as it was; a scan alone would show nothing of it, distances belong to the fitted surface.
    const overlay = state.overlay === "scan" ? "both" : state.overlay;
    store.set({ handPose: { fit: state.fit.id, nodes: move(nodes) }, overlay, showDistances: false });
  }

  return {
    scale: (bone: string, axis: Axis, value: number): void => change((nodes) => withScale(nodes, bone, axis, value)),
    weigh: (shape: number, value: number): void => change((nodes) => withWeight(nodes, shape, value)),
    reset: (): void => store.set({ handPose: null }),
  };
}

export type HandPoseActions = ReturnType<typeof handPoseActions>;
