// Makes the 3D view and keeps it up to date; without WebGL the page says so and the rest of it goes on working.
import type { Actions } from "./actions";
import { messageOf, withProblem } from "../store/problems";
import type { Stage } from "./Page";
import { isBeside, type Session } from "./session";
import type { Store } from "../store/store";
import { text } from "../ui/text";
import { openOtherView } from "../stances/OtherView";
import { CornerPins } from "../drawing/CornerPins";
import { OwnLines } from "../drawing/OwnLines";
import { listenToPen } from "../drawing/PenTool";
import { listenToPenKeys } from "../drawing/penKeys";
import { skinFrom } from "../drawing/skin";
import { listenToCanvasKeys } from "../landmarks/canvasKeys";
import { onClick } from "../viewer/clicks";
import { Crosshair } from "../viewer/Crosshair";
import { Drawings } from "../drawing/ReferenceLines";
import { listenToDrags } from "../landmarks/dragPins";
import { exportPicture } from "./exportPicture";
import { listenToFingers } from "../landmarks/fingers";
import { FittedSurface } from "../fit/FittedSurface";
import { HoverValue } from "../fit/HoverValue";
import { offerHook } from "../viewer/testHook";
import { LandmarkPins } from "../landmarks/LandmarkPins";
import { Loupe } from "../viewer/Loupe";
import { ModelPicture } from "../landmarks/ModelPicture";
import { OrientationCube } from "../viewer/OrientationCube";
import { pickAt } from "../viewer/picking";
import { ProposalPins } from "../landmarks/ProposalPins";
import { Ruler } from "../scan/Ruler";
import { ScanMesh } from "../scan/ScanMesh";
import { SideLetters } from "../viewer/SideLetters";
import { TorsoModel } from "../fit/TorsoModel";
import { type Part, Viewer } from "../viewer/Viewer";

export function openViewer(store: Store<Session>, actions: Actions, stage: Stage, prefersStill: () => boolean): void {
  let viewer: Viewer;
  try {
    viewer = new Viewer(stage.host, stage.canvas, stage.overlay, prefersStill);
  } catch {
    actions.page.graphics("absent");
    return;
  }
  const ready = (place: "scan" | "model" | "distances", words: string) => (error: unknown) => {
    if (error !== null) store.set((state) => withProblem(state, place, words));
    else updateAll(store.get());
  };
  const scan = new ScanMesh(viewer, ready("scan", text.errors.mesh));
  const torso = new TorsoModel(viewer, ready("model", text.errors.model));
  const fitted = new FittedSurface(viewer, ready("distances", text.errors.surface));
  const pins = new LandmarkPins(viewer, scan);
  const proposed = new ProposalPins(viewer, scan);
  const own = new OwnLines(viewer, scan);
  const corners = new CornerPins(viewer, scan);
  const loupe = new Loupe(viewer, scan, stage.canvas);
  const cross = new Crosshair(viewer, scan, loupe);
  const parts: Part[] = [
    proposed,
    scan,
    torso,
    fitted,
    new Drawings(viewer, scan, torso, fitted),
    own,
    corners,
    pins,
    new HoverValue(viewer, fitted, stage.canvas),
    new SideLetters(viewer),
    new Ruler(viewer),
    loupe,
    new OrientationCube(viewer, actions),
    cross,
    new ModelPicture(viewer, torso, stage.picture, stage.light),
  ];
  /** A part that fails must not keep the others from drawing, nor the state from changing: its error is reported later. */
  const updateAll = (state: Session): void => {
    viewer.share(state.fit !== null && isBeside(state.overlay) ? (state.overlay as "beside" | "swipe") : "one", state.swipe);
    for (const part of parts) {
      try {
        part.update(state);
      } catch (error) {
        queueMicrotask(() => reportError(error));
      }
    }
    viewer.invalidate();
  };

  let theme: Session["theme"] | null = null;
  let viewAsked = store.get().view.asked;
  store.subscribe((state) => {
    if (state.theme !== theme) {
      theme = state.theme; // the page has put it on the document before: the colours can be read
      viewer.repaint();
    }
    updateAll(state);
    if (state.view.asked !== viewAsked) viewer.lookFrom(state.view.name);
    viewAsked = state.view.asked;
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    viewer.repaint();
    updateAll(store.get());
  });

  actions.drawing.skinIs(skinFrom(() => scan.mesh?.geometry ?? null));
  listenToPen(stage.canvas, viewer, scan, own, corners, store, actions);
  listenToPenKeys(stage.canvas, viewer, scan, cross, store, actions);
  listenToDrags(stage.canvas, viewer, scan, pins, store, actions);
  actions.picture.takenBy(() => exportPicture(viewer, store.get()));
  listenToCanvasKeys(stage.canvas, viewer, scan, cross, store, actions);
  const fingers = listenToFingers(stage.canvas, viewer, cross, store, actions);
  onClick(stage.canvas, (event) => {
    if (fingers.isAimed(event)) return;
    const ghost = store.get().active === null ? proposed.at(event.clientX, event.clientY) : null;
    if (ghost !== null) return actions.landmarks.confirm([ghost]);
    const hit = store.get().active === null ? null : pickAt(viewer, scan, event.clientX, event.clientY);
    if (hit) actions.landmarks.place(hit.point);
  });
  stage.canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  stage.canvas.addEventListener("webglcontextlost", (event) => {
    event.preventDefault(); // asks the browser to bring it back
    actions.page.graphics("lost");
  });
  stage.canvas.addEventListener("webglcontextrestored", () => {
    actions.page.graphics("ok");
    viewer.invalidate();
  });
  const other = openOtherView(store, viewer, stage.other, prefersStill, (error) => store.set((state) => withProblem(state, "stances", messageOf(error))));
  offerHook(store, viewer, scan, fitted, other);
}
