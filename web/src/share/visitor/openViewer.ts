// The shared body: the same parts as the page's own view, without any that change something.
import { ReferenceLines } from "../../drawing/lines/ReferenceLines";
import { FittedSurface } from "../../fit/distances/FittedSurface";
import { HoverValue } from "../../fit/distances/HoverValue";
import { hasModelShown } from "../../fit/state";
import { TorsoModel } from "../../fit/TorsoModel";
import { ScanMesh } from "../../scan/ScanMesh";
import type { Store } from "../../store/store";
import { ScaleBar } from "../../viewer/ScaleBar";
import { SideLetters } from "../../viewer/SideLetters";
import { offerTestHook } from "../../viewer/testHook";
import { type Part, type Stage, Viewer } from "../../viewer/Viewer";
import type { VisitorState } from "./state";

export function openSharedViewer(store: Store<VisitorState>, stage: Stage, failed: () => void): void {
  const prefersStill = (): boolean => matchMedia("(prefers-reduced-motion: reduce)").matches;
  const viewer = new Viewer(stage.host, stage.canvas, stage.overlay, prefersStill);
  const ready = (error: unknown): void => {
    if (error !== null) failed();
    else update(store.get());
  };
  const scan = new ScanMesh(viewer, ready);
  const torso = new TorsoModel(viewer, ready); // stays empty: the rig is not part of a link
  const fitted = new FittedSurface(viewer, ready);
  const parts: Part<VisitorState>[] = [
    { update: (state) => scan.update(state, hasModelShown(state)) },
    fitted,
    new ReferenceLines(viewer, scan, torso, fitted),
    new SideLetters(viewer),
    new HoverValue(viewer, fitted, stage.canvas),
    new ScaleBar(viewer),
  ];
  function update(state: VisitorState): void {
    for (const part of parts) part.update(state);
    viewer.invalidate();
  }
  // Not part of the file that both pages share: the first view of the other one does without.
  void Promise.all([import("../../drawing/lines/Halos"), import("../../drawing/lesions/LesionBalls")]).then(([{ Halos }, { LesionBalls }]) => {
    const balls = new LesionBalls(viewer);
    parts.unshift({ update: ({ plan, lesion }) => balls.update({ plan, lesion, line: null }) }); // first: it turns the skin to glass
    parts.push(new Halos(viewer, scan, fitted, stage.canvas));
    update(store.get());
  });
  let asked = store.get().view.asked;
  store.subscribe((state) => {
    update(state);
    if (state.view.asked !== asked) viewer.lookFrom(state.view.name);
    asked = state.view.asked;
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    viewer.repaint();
    update(store.get());
  });
  offerTestHook(() => ({ ...store.get(), models: {} }), viewer, scan, fitted);
}
