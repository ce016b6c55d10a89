// What shows on a body how sure everything is: the bands of lines, the discs of landmarks, lesions with their reach, and the plan as
// it goes with a dragged landmark.  Loaded with the first fit or the first proposals: an empty page does without.
import type { FittedSurface } from "../fit/distances/FittedSurface";
import type { TorsoModel } from "../fit/TorsoModel";
import { LandmarkDiscs } from "../landmarks/LandmarkDiscs";
import type { ScanMesh } from "../scan/ScanMesh";
import type { Viewer } from "../viewer/Viewer";
import { FollowedPlan } from "./lines/FollowedPlan";
import { LesionBalls } from "./lesions/LesionBalls";
import { Halos } from "./lines/Halos";
import type { DrawingSlice, DrawnState } from "./state";

type Shown = Parameters<Halos["update"]>[0] & Parameters<LandmarkDiscs["update"]>[0] & Parameters<FollowedPlan["drawn"]>[0];

export class SureParts {
  private readonly balls: LesionBalls;
  private readonly halos: Halos;
  private readonly discs: LandmarkDiscs;
  private readonly plan: FollowedPlan;

  constructor(viewer: Viewer, scan: ScanMesh, fitted: FittedSurface, torso: TorsoModel, canvas: HTMLCanvasElement) {
    this.balls = new LesionBalls(viewer);
    this.halos = new Halos(viewer, scan, fitted, canvas);
    this.discs = new LandmarkDiscs(viewer, scan);
    this.plan = new FollowedPlan(torso, fitted, scan);
  }

  /** Before the skin, which turns to glass for a lesion that is looked at. */
  lesions({ drawn, lesion }: Pick<DrawingSlice, "drawn" | "lesion">): void {
    this.balls.update({ plan: drawn.onScan?.plan ?? null, lesion, line: drawn.chosen });
  }

  /** What is drawn, as it goes with a dragged landmark. */
  drawn(state: Shown): DrawnState {
    return this.plan.drawn(state);
  }

  /** `isFree`: the marks of landmarks are shown; `share`: of the bands' width that is expected of points that are being checked. */
  update(state: Shown, isFree: boolean, share = 1): void {
    this.halos.update(state, share);
    this.discs.update(state, isFree);
  }

  narrow(times: number): void {
    this.halos.narrow(times);
  }
}
