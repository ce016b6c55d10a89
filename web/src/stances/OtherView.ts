// The pane of the stance that waits: a view of its own, made when it is first wanted, whose camera goes with the other's.
import type { Matrix4 } from "three";
import { OwnLines } from "../drawing/lines/OwnLines";
import { ReferenceLines } from "../drawing/lines/ReferenceLines";
import type { SureParts } from "../drawing/sureParts";
import type { DrawingSlice } from "../drawing/state";
import { FittedSurface } from "../fit/distances/FittedSurface";
import { type FitSlice, hasModelShown } from "../fit/state";
import { TorsoModel } from "../fit/TorsoModel";
import { LandmarkPins } from "../landmarks/LandmarkPins";
import type { LandmarksSlice } from "../landmarks/state";
import { ScanMesh } from "../scan/ScanMesh";
import type { ScanSlice } from "../scan/state";
import type { PageSlice } from "../store/page";
import { fieldsOf, only, type Store } from "../store/store";
import { ScaleBar } from "../viewer/ScaleBar";
import { SideLetters } from "../viewer/SideLetters";
import type { ViewSlice } from "../viewer/state";
import type { OtherPane } from "../viewer/testHook";
import { followGraphics, type Part, type Stage, updateEach, Viewer } from "../viewer/Viewer";
import { linkedPose, torsoOf } from "./cameras";
import { FoundPins } from "./found/FoundPins";
import type { FoundSlice } from "./found/state";
import { MeasureLines } from "./measures/MeasureLines";
import { isComparing, otherState, type StancesSlice, type Workspace } from "./state";

type State = PageSlice & ViewSlice & ScanSlice & LandmarksSlice & FitSlice & DrawingSlice & StancesSlice & FoundSlice;

/** What of the state the pane shows, or follows; when something else changes it is not drawn again. */
const SEEN = ["meta", "models", "theme", "step", "overlay", "view", "scan", "showColours", "showLoose", "showRelief", "active", "found", "followed", "showDistances", "lesion"] as const;
type Seen = Pick<State, (typeof SEEN)[number] | "stances">;
const seen = (state: State): object => ({ ...only(...SEEN)(state), ...fieldsOf(state, "stances", "isCarrying") });

export function openOtherView(store: Store<State>, main: Viewer, stage: Stage, prefersStill: () => boolean, failed: (error: unknown) => void): OtherPane {
  let viewer: Viewer | null = null;
  let scan: ScanMesh | null = null;
  let parts: Part<Seen & Workspace>[] = [];
  let theme: string | null = null;
  let isFollowing = false; // a pose that was taken over is not handed back
  let viewAsked = store.get().view.asked;

  function follow(leader: Viewer, follower: Viewer): void {
    const state = store.get();
    const { other, isLinked } = state.stances;
    if (isFollowing || !isLinked || !other || !isComparing(state)) return;
    if (main.keepsPose || viewer?.keepsPose) return; // panes have changed hands, and a body is still to come: it stays as it was seen
    const isMain = leader === main;
    const [mine, its] = [torsoOf(state), torsoOf(other)];
    // By landmarks only when both have them: the middle of one body and the breastbone of the other are not one place.
    const origin = (of: Viewer): Matrix4 => of.body.matrixWorld.clone().invert();
    const [a, b] = mine && its ? [mine, its] : [origin(main), origin(viewer!)];
    const [from, to] = isMain ? [a, b] : [b, a];
    isFollowing = true;
    for (const each of [leader, follower]) each.scene.updateMatrixWorld();
    follower.pose = linkedPose(leader.pose, { world: leader.body.matrixWorld, torso: from }, { world: follower.body.matrixWorld, torso: to });
    isFollowing = false;
  }

  function make(): Viewer {
    const made = new Viewer(stage.host, stage.canvas, stage.overlay, prefersStill);
    const ready = (error: unknown): void => {
      if (error !== null) return failed(error);
      update(store.get());
      follow(main, made);
    };
    scan = new ScanMesh(made, ready);
    const torso = new TorsoModel(made, ready);
    const fitted = new FittedSurface(made, ready);
    const [body, pins] = [scan, new LandmarkPins(made, scan)];
    const skin = { get mesh() { return body.mesh ?? fitted.mesh; } }; // a predicted body has no scan
    let sure: SureParts | null = null;
    void import("../drawing/sureParts").then(({ SureParts }) => {
      sure = new SureParts(made, body, fitted, torso, stage.canvas);
      update(store.get());
    });
    parts = [
      { update: (state) => sure?.lesions(state) },
      { update: (state) => body.update(state, hasModelShown(state)) },
      torso,
      fitted,
      new ReferenceLines(made, scan, torso, fitted),
      { update: (state) => sure?.update(state, state.drawn.tool === "none") },
      new OwnLines(made, skin),
      new MeasureLines(made, true),
      { update: (state) => pins.update(state, state.drawn.tool === "none") },
      new FoundPins(made, body),
      new SideLetters(made),
      new ScaleBar(made),
    ];
    main.turned.add(() => follow(main, made));
    made.turned.add(() => (made.isHeld ? follow(made, main) : follow(main, made))); // not held: its pane has another size now
    followGraphics(stage.canvas, made, (otherGraphics) => store.set({ otherGraphics }));
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => made.repaint());
    return made;
  }

  function update(state: Seen): void {
    const other = otherState(state);
    if (!other || !isComparing(state)) return; // what is not to be seen is not drawn either
    try {
      viewer ??= make();
    } catch (error) {
      return failed(error);
    }
    if (state.theme !== theme) {
      theme = state.theme;
      viewer.repaint();
    }
    updateEach(parts, other);
    if (state.view.asked !== viewAsked && !state.stances.isLinked) viewer.lookFrom(state.view.name);
    viewAsked = state.view.asked;
    viewer.invalidate();
  }

  let wasComparing = false;
  let wasLinked = true;
  let before = store.get();
  store.select(seen, () => {
    const state = store.get();
    const isSwapped = state.scan !== null && state.scan === before.stances.other?.scan && before.scan === state.stances.other?.scan;
    if (isSwapped && viewer && isComparing(state)) {
      const [mine, its] = [main.pose, viewer.pose];
      isFollowing = true; // each body stays as it is seen, only the panes change hands
      [main.pose, viewer.pose] = [its, mine];
      isFollowing = false;
      main.keepsPose = viewer.keepsPose = true;
    }
    before = state;
    update(state);
    const now = isComparing(state);
    const isNew = now && (!wasComparing || (state.stances.isLinked && !wasLinked));
    wasComparing = now;
    wasLinked = state.stances.isLinked;
    if (isNew && viewer) requestAnimationFrame(() => viewer && follow(main, viewer)); // after the layout has changed
  });
  return { isReady: () => scan?.isSettled ?? false, viewer: () => viewer };
}
