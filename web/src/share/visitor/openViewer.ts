// The shared body: the same parts as the page's own view, without any that change something.
import type { Actions } from "../../app/actions";
import type { Stage } from "../../app/Page";
import type { Session } from "../../app/session";
import { isBeside } from "../../app/session";
import type { Store } from "../../store/store";
import { Drawings } from "../../drawing/ReferenceLines";
import { FittedSurface } from "../../fit/FittedSurface";
import { HoverValue } from "../../fit/HoverValue";
import { offerHook } from "../../viewer/testHook";
import { OrientationCube } from "../../viewer/OrientationCube";
import { ScanMesh } from "../../scan/ScanMesh";
import { SideLetters } from "../../viewer/SideLetters";
import { TorsoModel } from "../../fit/TorsoModel";
import { type Part, Viewer } from "../../viewer/Viewer";

export function openSharedViewer(store: Store<Session>, stage: Pick<Stage, "host" | "canvas" | "overlay">, actions: Pick<Actions, "page">, failed: () => void): void {
  const prefersStill = (): boolean => matchMedia("(prefers-reduced-motion: reduce)").matches;
  const viewer = new Viewer(stage.host, stage.canvas, stage.overlay, prefersStill);
  const ready = (error: unknown): void => {
    if (error !== null) failed();
    else update(store.get());
  };
  const scan = new ScanMesh(viewer, ready);
  const torso = new TorsoModel(viewer, ready); // stays empty: the rig is not part of a link
  const fitted = new FittedSurface(viewer, ready);
  const parts: Part[] = [scan, fitted, new Drawings(viewer, scan, torso, fitted), new SideLetters(viewer), new HoverValue(viewer, fitted, stage.canvas), new OrientationCube(viewer, actions)];
  function update(state: Session): void {
    viewer.share(isBeside(state.overlay) ? (state.overlay as "beside" | "swipe") : "one", state.swipe);
    for (const part of parts) part.update(state);
    viewer.invalidate();
  }
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
  offerHook(store, viewer, scan, fitted);
}
