// Makes the 3D view and keeps it up to date; without WebGL the page says so and the rest of it goes on working.
import type { Actions } from "../actions";
import { messageOf, withProblem } from "../actions/problems";
import type { Stage } from "../panels/Page";
import { isBeside, type Session } from "../state/session";
import type { Store } from "../state/store";
import { text } from "../text";
import { openOtherView } from "../stances/OtherView";
import { CornerPins } from "../drawing/CornerPins";
import { OwnLines } from "../drawing/OwnLines";
import { listenToPen } from "../drawing/PenTool";
import { listenToPenKeys } from "../drawing/penKeys";
import { skinFrom } from "../drawing/skin";
import { listenToCanvasKeys } from "./canvasKeys";
import { onClick } from "./clicks";
import { Crosshair } from "./Crosshair";
import { Drawings } from "./Drawings";
import { listenToDrags } from "./dragPins";
import { exportPicture } from "./exportPicture";
import { listenToFingers } from "./fingers";
import { FittedSurface } from "./FittedSurface";
import { HoverValue } from "./HoverValue";
import { offerHook } from "./hook";
import { LandmarkPins } from "./LandmarkPins";
import { Loupe } from "./Loupe";
import { ModelPicture } from "./ModelPicture";
import { OrientationCube } from "./OrientationCube";
import { pickAt } from "./picking";
import { ProposalPins } from "./ProposalPins";
import { Ruler } from "./Ruler";
import { ScanMesh } from "./ScanMesh";
import { SideLetters } from "./SideLetters";
import { TorsoModel } from "./TorsoModel";
import { type Part, Viewer } from "./Viewer";

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
