// Makes the 3D view and keeps it up to date; without WebGL the page says so and the rest of it goes on working.
import { narrowing } from "../checks/state";
import { CornerPins } from "../drawing/pen/CornerPins";
import { OwnLines } from "../drawing/lines/OwnLines";
import { listenToPenKeys } from "../drawing/pen/penKeys";
import { listenToPen } from "../drawing/pen/PenTool";
import { ReferenceLines } from "../drawing/lines/ReferenceLines";
import { skinFrom } from "../drawing/lines/skin";
import type { SureParts } from "../drawing/sureParts";
import { FittedSurface } from "../fit/distances/FittedSurface";
import { HoverValue } from "../fit/distances/HoverValue";
import { hasModelShown, isUnusable } from "../fit/state";
import { errors as fitErrors } from "../fit/text";
import { TorsoModel } from "../fit/TorsoModel";
import { linesOn } from "../fit/verdict";
import { listenToLandmarkKeys } from "../landmarks/canvasKeys";
import { followWanted } from "../landmarks/questions/closeUp";
import { listenToDrags } from "../landmarks/dragPins";
import { listenToFingers } from "../landmarks/fingers";
import { LandmarkPins } from "../landmarks/LandmarkPins";
import { ModelPicture } from "../landmarks/ModelPicture";
import { ProposalPins } from "../landmarks/proposals/ProposalPins";
import { RulerPins } from "../landmarks/size/RulerPins";
import { listenToLasso } from "../scan/cropping/CropTool";
import { ScanMesh } from "../scan/ScanMesh";
import { errors as scanErrors } from "../scan/text";
import { MeasureLines } from "../stances/measures/MeasureLines";
import { FoundPins } from "../stances/found/FoundPins";
import { openOtherView } from "../stances/OtherView";
import { isComparing, isPredicted, stanceNames, type Workspace } from "../stances/state";
import { stances as stancesText } from "../stances/text";
import type { Theme } from "../store/page";
import { messageOf, withProblem } from "../store/problems";
import { fieldsOf, only, type Store } from "../store/store";
import { onClick } from "../viewer/clicks";
import { Crosshair } from "../viewer/Crosshair";
import { listenToViewKeys } from "../viewer/keys";
import { Loupe } from "../viewer/Loupe";
import { pickAt } from "../viewer/picking";
import { ScaleBar } from "../viewer/ScaleBar";
import { SideLetters } from "../viewer/SideLetters";
import { offerTestHook } from "../viewer/testHook";
import { followGraphics, type Part, updateEach, Viewer } from "../viewer/Viewer";
import type { Actions } from "./actions";
import type { Pane } from "./exportPicture";
import type { Stages } from "./Page";
import type { Session } from "./session";

/** What of the state the view shows; when something else changes it is not drawn again. */
const SEEN = [
  ...(["meta", "models", "theme", "step", "overlay", "view", "loading", "scan", "showColours", "showLoose", "showRelief", "showMirror"] as const),
  ...(["picks", "certain", "proposals", "active", "beside", "found", "ruler", "fit", "followed", "showDistances", "drawing", "lesion", "ink", "inkPointed", "pointedCut", "checks"] as const),
];
type Seen = Pick<Session, (typeof SEEN)[number] | "drawn" | "stances">;

/** That something is being saved or carried is said beside the view. */
const seen = (state: Session): object => ({ ...only(...SEEN)(state), ...fieldsOf(state, "drawn", "saving"), ...fieldsOf(state, "stances", "isCarrying") });

export function openViewer(store: Store<Session>, actions: Actions, stages: Stages, prefersStill: () => boolean): void {
  const stage = stages.main;
  let viewer: Viewer;
  try {
    viewer = new Viewer(stage.host, stage.canvas, stage.overlay, prefersStill);
  } catch {
    actions.view.graphics("absent");
    return;
  }
  const ready = (place: "scan" | "model" | "distances", words: string) => (error: unknown) => {
    if (error !== null) store.set((state) => withProblem(state, place, words));
    else updateAll(store.get());
  };
  const scan = new ScanMesh(viewer, ready("scan", scanErrors.mesh));
  const torso = new TorsoModel(viewer, ready("model", fitErrors.model));
  const fitted = new FittedSurface(viewer, ready("distances", fitErrors.surface));
  const pins = new LandmarkPins(viewer, scan);
  const proposed = new ProposalPins(viewer, scan);
  const ruler = new RulerPins(viewer, scan);
  const own = new OwnLines(viewer, scan);
  const corners = new CornerPins(viewer, scan);
  const loupe = new Loupe(viewer, scan, stage.canvas);
  const cross = new Crosshair(viewer, scan, loupe);
  const isFree = ({ drawn, checks }: Pick<Session, "drawn" | "checks">): boolean => drawn.tool === "none" && checks.tour === null;
  const reference = new ReferenceLines(viewer, scan, torso, fitted);
  let sure: SureParts | null = null;
  const asFollowed = (state: Seen): Seen => (sure ? { ...state, drawn: sure.drawn(state) } : state);
  const parts: Part<Seen>[] = [
    { update: (state) => sure?.lesions(state) }, // first: it turns the skin to glass
    proposed,
    { update: (state) => scan.update(state, hasModelShown(state)) },
    torso,
    fitted,
    { update: (state) => reference.update(asFollowed(state)) },
    { update: (state) => sure?.update(asFollowed(state), isFree(state), narrowing(state)) },
    { update: (state) => own.update(asFollowed(state)) },
    corners,
    new MeasureLines(viewer, false),
    { update: (state) => pins.update(state, isFree(state)) },
    new FoundPins(viewer, scan),
    ruler,
    new HoverValue(viewer, fitted, stage.canvas),
    new SideLetters(viewer),
    new ScaleBar(viewer),
    { update: ({ active }) => loupe.arm(active !== null) },
    // The cross serves the placing of landmarks and the tools that draw.
    { update: ({ active, drawn }) => active === null && (drawn.tool === "none" || drawn.tool === "points") && cross.hide() },
    new ModelPicture(viewer, torso, stages.picture, stages.light),
  ];
  const updateAll = (state: Seen): void => {
    updateEach(parts, state);
    viewer.invalidate();
  };

  /** A part that is loaded when it is wanted for the first time. */
  const later = <Kept extends keyof Seen>(keys: readonly Kept[], isWanted: (state: Pick<Seen, Kept>) => boolean, load: () => Promise<void>): void => {
    let isAsked = false;
    store.select(only(...keys), (state) => {
      if (isAsked || !isWanted(state)) return;
      isAsked = true;
      void load().then(() => updateAll(store.get()));
    });
  };
  later(["fit", "proposals"], ({ fit, proposals }) => fit !== null || proposals !== null, async () => {
    const { SureParts } = await import("../drawing/sureParts");
    sure = new SureParts(viewer, scan, fitted, torso, stage.canvas);
  });
  later(["drawn"], ({ drawn }) => drawn.live !== null, async () => {
    const { PatternHandles } = await import("../drawing/patterns/PatternHandles");
    parts.push(new PatternHandles(viewer, scan, actions.drawing, actions.handles, stages.main.canvas));
  });
  later(["drawn"], ({ drawn }) => drawn.tape !== null, async () => {
    const { TapeLines } = await import("../drawing/tape/TapeLines");
    parts.push(new TapeLines(viewer, scan));
  });
  later(["showMirror"], ({ showMirror }) => showMirror, async () => {
    const { MirrorOverlay } = await import("../drawing/mirror/MirrorOverlay");
    parts.push(new MirrorOverlay(viewer, fitted, (asymmetry) => queueMicrotask(() => store.set({ asymmetry })))); // a listener may not set
  });
  later(["ink"], ({ ink }) => Object.keys(ink).length > 0, async () => {
    const { InkLines } = await import("../ink/InkLines");
    parts.push(new InkLines(viewer));
  });
  later(["checks"], ({ checks }) => checks.tour !== null, async () => {
    const { openCheckStage } = await import("../checks/CheckStage");
    openCheckStage(store, viewer, scan, torso, stage.canvas, actions.checks);
  });
  store.select(only("checks"), ({ checks: { outcome } }, before) => {
    if (outcome && outcome !== before.checks.outcome && !prefersStill()) sure?.narrow(Math.max(1, (outcome.from ?? 0) / (outcome.to ?? Infinity)));
  });

  let hasSlices = false;
  store.select(only("slices"), ({ slices }) => {
    if (hasSlices || slices.of === null) return;
    hasSlices = true;
    void import("../stances/slices/bodyCross").then(({ followSlices }) => {
      const second = (): Viewer | null => other.viewer();
      followSlices(store, actions.drawing.slices, {
        main: () => ({ viewer, canvas: stage.canvas, surface: scan }),
        other: () => second() && { viewer: second()!, canvas: stages.other.canvas, surface: null },
      });
    });
  });

  let theme: Theme | null = null;
  let viewAsked = store.get().view.asked;
  store.select(seen, () => {
    const state = store.get();
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

  actions.drawing.setSkin(skinFrom(() => scan.mesh?.geometry ?? null));
  listenToLasso(stage.canvas, viewer, scan, cross, store, actions.scan); // before the pen, which says last what turns the body
  listenToPen(stage.canvas, viewer, scan, own, corners, store, actions.drawing);
  listenToPenKeys(stage.canvas, viewer, scan, cross, store, actions.drawing);
  actions.landmarks.seenBy((point) => proposed.isLookedAt(point));
  const mayDrag = (): boolean => store.get().active === null && !store.get().isCropping && isFree(store.get());
  listenToDrags(stage.canvas, viewer, scan, pins, mayDrag, actions.landmarks, actions.follower);
  followWanted(viewer, scan, store); // before the keys, whose cross stands where the eye then is
  listenToLandmarkKeys(stage.canvas, viewer, scan, cross, store, actions.landmarks);
  listenToViewKeys(stage.canvas, viewer, () => store.get().scan !== null);
  const fingers = listenToFingers(stage.canvas, viewer, cross, store, actions.landmarks);
  onClick(stage.canvas, (event) => {
    if (fingers.isAimed(event)) return;
    if (store.get().checks.tour) return;
    const proposal = store.get().active === null ? proposed.at(event.clientX, event.clientY) : null;
    if (proposal !== null) return actions.landmarks.confirm([proposal]);
    const hit = store.get().active === null ? null : pickAt(viewer, scan, event.clientX, event.clientY);
    if (hit) actions.landmarks.place(hit.point);
  });
  followGraphics(stage.canvas, viewer, actions.view.graphics);
  const other = openOtherView(store, viewer, stages.other, prefersStill, (error) => store.set((state) => withProblem(state, "stances", messageOf(error))));
  actions.files.setPicture(async () => (await import("./exportPicture")).exportPicture(panesOf(viewer, other.viewer(), store.get()), store.get()));
  offerTestHook(() => ({ ...store.get(), models: {} }), viewer, scan, fitted, other);
}

/** From left to right, as they stand on the stage. */
function panesOf(main: Viewer, other: Viewer | null, state: Session): Pane[] {
  const sure = (of: Workspace): number | null | undefined => (of.fit?.state === "done" && !isUnusable(of) ? (linesOn(of)?.mm ?? null) : undefined);
  if (!other || !isComparing(state)) return [{ viewer: main, title: "", lines: sure(state) }];
  const [mine, its] = stanceNames(state);
  const panes = [{ viewer: main, title: mine, lines: sure(state) }, { viewer: other, title: isPredicted(state.stances.other!) ? stancesText.predicted.picture(its) : its, lines: sure(state.stances.other!) }];
  return state.stances.isSecond ? panes.reverse() : panes;
}
