// Placed landmarks as numbered marks over the picture: circle = patient's left, square = right, diamond = midline.
// DOM and not 3D: always sharp, never half sunk into the skin; a pin behind the body fades.
import { Vector3 } from "three";
import { el } from "../dom";
import { sideOf } from "../state/landmarks";
import type { Session } from "../state/session";
import { metresFromMm } from "../units";
import { isHidden } from "./picking";
import type { ScanMesh } from "./ScanMesh";
import type { Part, Viewer } from "./Viewer";

interface Pin {
  element: HTMLElement;
  point: Vector3; // scan's frame, metres
  normal: Vector3 | null; // of the skin there; null until the scan is loaded
}

export class LandmarkPins implements Part {
  private readonly pins = new Map<string, Pin>();
  private drawn: unknown = null;

  constructor(
    private readonly viewer: Viewer,
    private readonly scan: ScanMesh,
  ) {
    viewer.beforeFrame.add(() => this.place());
  }

  update(state: Session): void {
    const picks = state.picks.present;
    const isShown = state.scan !== null && state.overlay !== "model";
    for (const pin of this.pins.values()) pin.element.hidden = !isShown;
    for (const [name, pin] of this.pins) pin.element.classList.toggle("is-active", name === state.active);
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
      this.pins.set(name, { element: known?.element ?? this.make(name, number), point, normal: null });
    }
    this.viewer.invalidate();
  }

  private make(name: string, number: number): HTMLElement {
    const mark = el("span", { class: `mark side-${sideOf(name)}` }, el("span", {}, String(number)));
    const element = el("div", { class: "pin", "data-landmark": name }, mark);
    this.viewer.overlay.append(element);
    return element;
  }

  private place(): void {
    for (const pin of this.pins.values()) {
      const { element, point } = pin;
      pin.normal ??= this.scan.normalAt(point);
      const { x, y } = this.viewer.toScreen(point);
      element.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
      element.classList.toggle("is-hidden", isHidden(this.viewer, this.scan, point, pin.normal));
    }
  }
}
