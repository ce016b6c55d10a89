// A cross on the picture that stands for the pointer where there is none: moved by arrow keys, or held above a finger.
import { el } from "../ui/dom";
import type { Loupe } from "./Loupe";
import { type Hit, pickAt, type Surface } from "./picking";
import type { Viewer } from "./Viewer";

interface Place {
  x: number;
  y: number;
}

export class Crosshair {
  private readonly element = el("div", { class: "crosshair reticle", hidden: true });
  private at: Place | null = null; // page pixels

  constructor(
    private readonly viewer: Viewer,
    private readonly scan: Surface,
    private readonly loupe: Loupe,
  ) {
    viewer.overlay.append(this.element);
  }

  get isShown(): boolean {
    return this.at !== null;
  }

  /** Puts it at page pixels, kept within the stage; the loupe goes with it. */
  show(x: number, y: number): void {
    const box = this.viewer.host.getBoundingClientRect();
    this.at = { x: Math.min(Math.max(x, box.left), box.right - 1), y: Math.min(Math.max(y, box.top), box.bottom - 1) };
    this.element.hidden = false;
    this.element.style.transform = `translate(${(this.at.x - box.left).toFixed(1)}px, ${(this.at.y - box.top).toFixed(1)}px)`;
    this.element.classList.toggle("is-beside", this.hit === null);
    this.loupe.look(this.at);
  }

  moveBy(x: number, y: number): void {
    if (this.at) this.show(this.at.x + x, this.at.y + y);
  }

  hide(): void {
    if (!this.at) return;
    this.at = null;
    this.element.hidden = true;
    this.loupe.look(null);
  }

  /** Page pixels; null while it is not shown. */
  get place(): Readonly<Place> | null {
    return this.at;
  }

  /** What of the scan lies under it. */
  get hit(): Hit | null {
    return this.at && pickAt(this.viewer, this.scan, this.at.x, this.at.y);
  }
}
