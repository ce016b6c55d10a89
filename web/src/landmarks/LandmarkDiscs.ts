// How sure the place of each shown landmark is: the skin within its 90 % radius.  Of a fit it lies around the model's landmark, of a
// proposal around the proposed place.
import { Vector3 } from "three";
import type { Result, Unit, Vector } from "../api/types";
import type { ScanSlice } from "../scan/state";
import type { PageSlice } from "../store/page";
import { metresFromMm, mmFrom } from "../ui/units";
import { Halo } from "../viewer/lines/Halo";
import type { Banded } from "../viewer/lines/haloPatch";
import type { Surface } from "../viewer/picking";
import type { ViewSlice } from "../viewer/state";
import type { Viewer } from "../viewer/Viewer";
import { onlyAgreed } from "./proposals/agreed";
import { openProposals } from "./proposals/proposals";
import type { LandmarksSlice } from "./state";

/** What of a fit says how far each landmark may be off. */
interface Judged {
  readonly result: (Pick<Result, "landmarks" | "landmark_uncertainty_mm"> & { readonly scan: { readonly unit: string } }) | null;
}

type Shown = Pick<PageSlice & ViewSlice & ScanSlice & LandmarksSlice, "step" | "overlay" | "scan" | "picks" | "certain" | "proposals"> & { readonly fit: Judged | null };

interface Disc {
  readonly point: Vector; // mm, scan's axes
  readonly mm: number;
}

/** By name: of those that are placed, and while landmarks are looked at of those that are proposed. */
function discsOf(state: Shown): Readonly<Record<string, Disc>> {
  const { fit, picks, proposals, step } = state;
  const found: Record<string, Disc> = {};
  if (proposals?.state === "found") {
    const named = [...(step === "points" ? openProposals(proposals, picks.present).map(({ name }) => name) : []), ...Object.keys(onlyAgreed(state))];
    for (const name of named) {
      const { point, error_mm: mm } = proposals.landmarks[name]!;
      if (mm != null) found[name] = { point, mm };
    }
  }
  const { result } = fit ?? {};
  for (const [name, mm] of Object.entries(result?.landmark_uncertainty_mm ?? {})) {
    const at = result!.landmarks[name];
    if (at && name in picks.present) found[name] = { point: at.map((value) => mmFrom(value, result!.scan.unit as Unit)) as Vector, mm };
  }
  return found;
}

export class LandmarkDiscs {
  private readonly halo: Halo;
  private shown: unknown[] = [];

  constructor(
    private readonly viewer: Viewer,
    private readonly scan: Surface & { readonly bvh: unknown },
  ) {
    this.halo = new Halo(viewer, "discs of landmarks", 8.5); // under those of lines
  }

  /** `isFree`: the marks are shown, no tool that draws is in the hand. */
  update(state: Shown, isFree: boolean): void {
    const { scan, viewer } = this;
    const isShown = state.scan !== null && state.overlay !== "model" && isFree && scan.bvh !== null;
    const now = [isShown, scan.bvh, state.fit?.result, state.picks, state.certain, state.proposals, state.step === "points", viewer.palette];
    if (now.every((each, i) => each === this.shown[i])) return;
    this.shown = now;
    const discs = isShown ? Object.values(discsOf(state)) : [];
    this.halo.set(discs.map((disc) => bandedDisc(disc, scan, viewer)), scan.mesh?.geometry ?? null);
  }
}

/** As the halo draws it. */
export function bandedDisc({ point, mm }: Disc, scan: Surface, { palette }: Viewer): Banded {
  const at = new Vector3(...point.map(metresFromMm));
  return { points: new Float32Array(at.toArray()), normals: new Float32Array((scan.normalAt(at) ?? new Vector3()).toArray()), radii: new Float32Array([metresFromMm(mm)]), isClosed: false, tint: palette.ink };
}
