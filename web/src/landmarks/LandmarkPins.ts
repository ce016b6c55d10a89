// Placed landmarks as numbered marks over the picture: circle = patient's left, square = right, diamond = midline.
// DOM and not 3D: always sharp, never half sunk into the skin; a pin behind the body fades.
import { Vector3 } from "three";
import type { Vector } from "../api/types";
import type { ScanSlice } from "../scan/state";
import type { PageSlice } from "../store/page";
import { el } from "../ui/dom";
import { metresFromMm } from "../ui/units";
import { isHidden, type Surface } from "../viewer/picking";
import type { ViewSlice } from "../viewer/state";
import type { Viewer } from "../viewer/Viewer";
import { type Picks, sideOf } from "./picks";
import { onlyAgreed } from "./proposals/agreed";
import { type Asked, askedNames, openQuestions } from "./questions/questions";
import type { LandmarksSlice } from "./state";

type Shown = Pick<PageSlice & ViewSlice & ScanSlice & LandmarksSlice, "meta" | "overlay" | "scan" | "picks" | "certain" | "proposals" | "active"> & Pick<Asked, "fit">;

const REACH = 12; // pixels from a mark's middle that still hold it: a target of 24

interface Pin {
  element: HTMLElement;
  point: Vector3; // scan's frame, metres
  normal: Vector3 | null; // of the skin there; null until the scan is loaded
  at: { x: number; y: number } | null; // in the host's box; null while it is not to be seen
}

export class LandmarkPins {
  private readonly pins = new Map<string, Pin>();
  private drawn: unknown = null;
  private isShown = false;
  private held: { name: string; point: Vector3 } | null = null;

  constructor(
    private readonly viewer: Viewer,
    private readonly scan: Surface,
  ) {
    viewer.beforeFrame.add(() => this.place());
  }

  /** `isFree`: no tool that draws is in the hand; then the marks would be in its way. */
  update(state: Shown, isFree: boolean): void {
    const picks = state.picks.present;
    const isShown = (this.isShown = state.scan !== null && state.overlay !== "model" && isFree);
    for (const pin of this.pins.values()) pin.element.hidden = !isShown;
    for (const [name, pin] of this.pins) pin.element.classList.toggle("is-active", name === state.active);
    this.draw(state, picks);
    const agreed = onlyAgreed(state);
    for (const [name, pin] of this.pins) pin.element.classList.toggle("is-agreed", name in agreed);
    const asked = askedNames(openQuestions(state));
    for (const [name, pin] of this.pins) pin.element.classList.toggle("is-asked", asked.has(name));
  }

  private draw(state: Shown, picks: Picks): void {
    if (picks === this.drawn) return;
    this.drawn = picks;
    for (const [name, pin] of this.pins) {
      if (name in picks) continue;
      pin.element.remove();
      this.pins.delete(name);
    }
    for (const [name, at] of Object.entries(picks)) {
      const point = new Vector3(...at.map(metresFromMm));
      const number = 1 + (state.meta?.landmarks.findIndex((entry) => entry.name === name) ?? -1);
      const known = this.pins.get(name);
      this.pins.set(name, { element: known?.element ?? this.make(name, number), point, normal: null, at: null });
    }
    this.viewer.invalidate();
  }

  /** The placed landmark under page pixels, or null. */
  at(clientX: number, clientY: number): string | null {
    if (!this.isShown) return null;
    const box = this.viewer.host.getBoundingClientRect();
    const away = ({ at }: Pin): number => (at ? Math.hypot(at.x + box.left - clientX, at.y + box.top - clientY) : Infinity);
    const nearest = [...this.pins].sort(([, a], [, b]) => away(a) - away(b))[0];
    return nearest && away(nearest[1]) <= REACH ? nearest[0] : null;
  }

  /** While it is dragged a mark stands elsewhere than the state says; null ends that. */
  hold(name: string | null, point: Vector | null): void {
    this.held = name && point ? { name, point: new Vector3(...point.map(metresFromMm)) } : null;
    this.viewer.invalidate();
  }

  private make(name: string, number: number): HTMLElement {
    const mark = el("span", { class: `mark side-${sideOf(name)}` }, el("span", {}, String(number)));
    const element = el("div", { class: "pin", "data-landmark": name }, mark);
    this.viewer.overlay.append(element);
    return element;
  }

  private place(): void {
    for (const [name, pin] of this.pins) {
      const { element } = pin;
      const isHeld = this.held?.name === name;
      const point = isHeld ? this.held!.point : pin.point;
      pin.normal ??= this.scan.normalAt(point);
      const { x, y } = this.viewer.toScreen(point);
      element.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
      const hidden = !isHeld && isHidden(this.viewer, this.scan, point, pin.normal);
      element.classList.toggle("is-hidden", hidden);
      element.classList.toggle("is-held", isHeld);
      pin.at = hidden ? null : { x, y };
    }
  }
}
