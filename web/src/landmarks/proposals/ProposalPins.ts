// Proposed landmarks as dashed, hollow marks over the picture, each in the disc where it may lie (LandmarkDiscs).
// They must not look like placed ones; a click on one confirms it.
import { Vector3 } from "three";
import type { Vector } from "../../api/types";
import type { ScanSlice } from "../../scan/state";
import type { PageSlice } from "../../store/page";
import { el } from "../../ui/dom";
import { metresFromMm } from "../../ui/units";
import { isHidden, type Surface } from "../../viewer/picking";
import type { ViewSlice } from "../../viewer/state";
import type { Part, Viewer } from "../../viewer/Viewer";
import { sideOf } from "../picks";
import { isLookedAt } from "./agreed";
import { isLikely, type OpenProposal, openProposals, type Proposals } from "./proposals";
import type { LandmarksSlice } from "../state";

type Shown = Pick<PageSlice & ViewSlice & ScanSlice & LandmarksSlice, "meta" | "step" | "overlay" | "scan" | "picks" | "proposals" | "active">;

const REACH = 14; // pixels from a mark's middle that still hit it: a target of 28

interface Pin {
  readonly name: string;
  readonly element: HTMLElement;
  readonly point: Vector3; // scan's frame, metres
  at: { x: number; y: number } | null; // in the host's box; null while it is not to be seen
}

export class ProposalPins implements Part<Shown> {
  private pins: Pin[] = [];
  private isShown = false;
  private drawn: { proposals: Proposals | null; picks: unknown } = { proposals: null, picks: null };

  constructor(
    private readonly viewer: Viewer,
    private readonly scan: Surface,
  ) {
    viewer.beforeFrame.add(() => this.place());
  }

  /** The proposal under page pixels, or null. */
  at(clientX: number, clientY: number): string | null {
    const box = this.viewer.host.getBoundingClientRect();
    const near = this.pins
      .filter((pin) => this.isShown && pin.at !== null)
      .map((pin) => ({ name: pin.name, away: Math.hypot(pin.at!.x - clientX + box.left, pin.at!.y - clientY + box.top) }))
      .sort((a, b) => a.away - b.away)[0];
    return near && near.away <= REACH ? near.name : null;
  }

  /** Whether a place of the skin (mm, scan's axes) is in the view, and single millimetres of it are seen. */
  isLookedAt(place: Vector): boolean {
    const point = new Vector3(...place.map(metresFromMm));
    const { x, y } = this.viewer.toScreen(point);
    const { clientWidth, clientHeight } = this.viewer.host;
    const isIn = x >= 0 && y >= 0 && x <= clientWidth && y <= clientHeight;
    return isIn && isLookedAt(this.viewer.pixelsPerMetre) && !isHidden(this.viewer, this.scan, point, this.scan.normalAt(point));
  }

  update(state: Shown): void {
    this.isShown = state.scan !== null && state.step === "points" && state.overlay !== "model";
    const { proposals } = state;
    const picks = state.picks.present;
    if (proposals !== this.drawn.proposals || picks !== this.drawn.picks) {
      this.drawn = { proposals, picks };
      for (const pin of this.pins) pin.element.remove();
      const numbers = new Map(state.meta?.landmarks.map((entry, i) => [entry.name, i + 1]));
      this.pins = openProposals(proposals, picks).map((proposal) => this.make(proposal, numbers.get(proposal.name) ?? 0));
    }
    for (const pin of this.pins) {
      pin.element.hidden = !this.isShown;
      pin.element.classList.toggle("is-active", pin.name === state.active);
    }
    this.viewer.invalidate();
  }

  private make(proposal: OpenProposal, number: number): Pin {
    const mark = el("span", { class: `mark side-${sideOf(proposal.name)}` }, el("span", {}, String(number)));
    const element = el("div", { class: `pin is-proposed${isLikely(proposal) ? "" : " is-rough"}`, "data-proposed": proposal.name }, mark);
    this.viewer.overlay.append(element);
    return { name: proposal.name, element, point: new Vector3(...proposal.point.map(metresFromMm)), at: null };
  }

  private place(): void {
    if (!this.isShown) return;
    for (const pin of this.pins) {
      const { x, y } = this.viewer.toScreen(pin.point);
      pin.element.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
      const hidden = isHidden(this.viewer, this.scan, pin.point, this.scan.normalAt(pin.point));
      pin.element.classList.toggle("is-hidden", hidden);
      pin.at = hidden ? null : { x, y };
    }
  }
}
