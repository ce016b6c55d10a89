// Proposed landmarks as dashed, hollow marks over the picture, each in the disc where it may lie (LandmarkDiscs).
// They must not look like placed ones; a click on one confirms it.
import { Vector3 } from "three";
import type { Vector } from "../../api/types";
import type { ScanSlice } from "../../scan/state";
import type { PageSlice } from "../../store/page";
import { el } from "../../ui/dom";
import { metresFromMm } from "../../ui/units";
import { isHidden, type Surface } from "../../viewer/picking";
import { Pins } from "../../viewer/Pins";
import type { ViewSlice } from "../../viewer/state";
import type { Part, Viewer } from "../../viewer/Viewer";
import { numberedMark } from "../LandmarkPins";
import type { MarksSlice } from "../marks/marks";
import { isLookedAt } from "./agreed";
import { isLikely, openProposals } from "./proposals";
import type { LandmarksSlice } from "../state";

type Shown = Pick<PageSlice & ViewSlice & ScanSlice & LandmarksSlice & MarksSlice, "meta" | "step" | "overlay" | "scan" | "picks" | "proposals" | "active" | "beside">;

export class ProposalPins extends Pins<string> implements Part<Shown> {
  private drawn: readonly unknown[] = [];

  constructor(viewer: Viewer, private readonly skin: Surface) {
    super(viewer, skin, 14);
  }

  /** Whether a place of the skin (mm, scan's axes) is in the view, and single millimetres of it are seen. */
  isLookedAt(place: Vector): boolean {
    const point = new Vector3(...place.map(metresFromMm));
    const { x, y } = this.viewer.toScreen(point);
    const { clientWidth, clientHeight } = this.viewer.host;
    const isIn = x >= 0 && y >= 0 && x <= clientWidth && y <= clientHeight;
    return isIn && isLookedAt(this.viewer.pixelsPerMetre) && !isHidden(this.viewer, this.skin, point, this.skin.normalAt(point));
  }

  update(state: Shown): void {
    const { active } = state;
    const mark = active === null || active in state.picks.present ? null : (state.beside[active] ?? null); // wanted: until then it would only lead the hand
    const now = [state.proposals, state.picks.present, active, mark];
    if (now.some((each, i) => each !== this.drawn[i])) {
      this.drawn = now;
      const open = new Map(openProposals(state.proposals, state.picks.present).map((proposal) => [proposal.name, proposal]));
      this.set([], () => el("div", {})); // a new proposal of the same name may look otherwise
      const places = [...open].map(([name, { point }]) => [name, point] as const);
      this.set(mark === null ? places : [...places, [active!, mark]], (name) => el("div", { class: `pin is-proposed${open.has(name) && !isLikely(open.get(name)!) ? " is-rough" : ""}`, "data-proposed": name }, numberedMark(state, name)));
    }
    this.show(state.scan !== null && state.step === "points" && state.overlay !== "model");
    this.toggle("is-active", (name) => name === state.active);
  }
}
