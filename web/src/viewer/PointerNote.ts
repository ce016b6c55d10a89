// A value and what it means, beside the pointer.
import { el, setText } from "../ui/dom";
import { onceAFrame } from "./onceAFrame";
import type { Viewer } from "./Viewer";

const AWAY = 16; // pixels from the pointer

export class PointerNote {
  private readonly value = el("strong", {});
  private readonly note = el("span", {});
  private readonly element: HTMLElement;
  private pointer: PointerEvent | null = null;
  private readonly later = onceAFrame(() => this.place());

  /** `says`: value and note under page pixels; null where there are none. */
  constructor(
    private readonly viewer: Viewer,
    canvas: HTMLCanvasElement,
    look: string,
    private readonly isAbove: boolean,
    private readonly says: (clientX: number, clientY: number) => readonly [value: string, note: string] | null,
  ) {
    this.element = el("div", { class: look, hidden: true }, this.value, this.note);
    viewer.overlay.append(this.element);
    canvas.addEventListener("pointermove", (event) => this.follow(event.buttons === 0 || event.pointerType === "touch" ? event : null));
    canvas.addEventListener("pointerdown", (event) => this.follow(event.pointerType === "touch" ? event : null));
    canvas.addEventListener("pointerleave", () => this.follow(null));
  }

  /** What lies under the pointer may have changed. */
  update(): void {
    if (this.pointer || !this.element.hidden) this.later();
  }

  private follow(pointer: PointerEvent | null): void {
    this.pointer = pointer;
    this.update();
  }

  private place(): void {
    const { pointer, element } = this;
    const said = pointer && this.says(pointer.clientX, pointer.clientY);
    element.hidden = !said;
    if (!said) return;
    setText(this.value, said[0]);
    setText(this.note, said[1]);
    const box = this.viewer.host.getBoundingClientRect();
    const x = Math.min(pointer.clientX - box.left + AWAY, box.width - element.offsetWidth - 8);
    const top = pointer.clientY - box.top;
    const y = this.isAbove ? Math.max(top - element.offsetHeight - AWAY / 2, 8) : Math.min(top + AWAY, box.height - element.offsetHeight - 8);
    element.style.transform = `translate(${x.toFixed(0)}px, ${y.toFixed(0)}px)`;
  }
}
