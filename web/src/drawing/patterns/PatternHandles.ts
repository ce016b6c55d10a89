// Handles of patterns and tumour on the body: buttons over the picture, for mouse, touch, pen and keys.
// Each says its number; while it is held, also where it goes no farther.
import { Vector3 } from "three";
import type { Vector } from "../../api/types";
import type { FitSlice } from "../../fit/state";
import type { ScanSlice } from "../../scan/state";
import type { PageSlice } from "../../store/page";
import { el, setText } from "../../ui/dom";
import { metresFromMm } from "../../ui/units";
import { ARROWS } from "../../viewer/keys";
import { isHidden, type Surface } from "../../viewer/picking";
import type { ViewSlice } from "../../viewer/state";
import type { Part, Viewer } from "../../viewer/Viewer";
import type { DrawingActions } from "../actions";
import { type HandleActions, hasHandles } from "./handles";
import { skinAt } from "../pen/penPlace";
import type { DrawingSlice, LiveHandle } from "../state";
import * as text from "../text";

const words = text.drawing.handles;
const MOVED = 3; // pixels; less is a click, which only chooses
const FAR = 5; // times as far with Shift, as everywhere

type Shown = Pick<PageSlice & ViewSlice & ScanSlice & FitSlice & DrawingSlice, "step" | "overlay" | "fit" | "drawn">;

interface Mark {
  readonly element: HTMLButtonElement;
  readonly says: HTMLElement;
  handle: LiveHandle;
  point: Vector3; // scan's frame, metres
  normal: Vector3 | null;
}

export class PatternHandles implements Part<Shown> {
  private readonly marks = new Map<string, Mark>();
  private readonly element = el("div", { class: "handles" }, el("p", { class: "visually-hidden", id: "handle-keys" }, words.keys));
  private isShown = false;
  private start: { readonly id: number; readonly x: number; readonly y: number; readonly dx: number; readonly dy: number; moved: boolean } | null = null; // of the drag

  constructor(
    private readonly viewer: Viewer,
    private readonly scan: Surface,
    private readonly drawing: Pick<DrawingActions, "skin">,
    private readonly handles: HandleActions,
    canvas: HTMLCanvasElement,
  ) {
    // The camera listens to the canvas alone: without this the wheel would stand still over a handle.
    this.element.addEventListener("wheel", (event) => {
      event.preventDefault();
      canvas.dispatchEvent(new WheelEvent("wheel", event));
    }, { passive: false });
    viewer.overlay.after(this.element); // not in the overlay, which is nothing to those who cannot see it
    viewer.beforeFrame.add(() => this.place());
  }

  update(state: Shown): void {
    const { live } = state.drawn;
    this.isShown = hasHandles(state) && state.overlay !== "model" && live !== null;
    const now = this.isShown ? live!.handles : [];
    const ids = new Set(now.map(({ id }) => id));
    for (const [id, mark] of this.marks) {
      if (ids.has(id)) continue;
      if (this.start && mark.element.hasPointerCapture(this.start.id)) this.start = null; // its end will not be heard of
      mark.element.remove();
      this.marks.delete(id);
    }
    for (const handle of now) {
      const mark = this.marks.get(handle.id) ?? this.make(handle);
      if (mark.handle !== handle || mark.normal === null) {
        mark.handle = handle;
        mark.point = new Vector3(...(handle.at_mm).map(metresFromMm));
        mark.normal = this.scan.normalAt(mark.point);
      }
      const isHeld = live!.held === handle.id;
      mark.element.classList.toggle("is-held", isHeld);
      const said = words.says(handle);
      mark.element.setAttribute("aria-label", said);
      setText(mark.says, isHeld && live!.limit !== "" ? `${said}. ${live!.limit}` : said);
      mark.element.classList.toggle("is-ended", isHeld && live!.limit !== "");
    }
    this.viewer.invalidate();
  }

  private make(handle: LiveHandle): Mark {
    const says = el("span", { class: "handle-says", "aria-hidden": "true" });
    const element = el("button", { type: "button", class: `handle of-${handle.part}`, "data-handle": handle.id, "aria-describedby": "handle-keys" }, says);
    const mark: Mark = { element, says, handle, point: new Vector3(), normal: null };
    this.listen(mark);
    this.element.append(element);
    this.marks.set(handle.id, mark);
    return mark;
  }

  private listen(mark: Mark): void {
    const { element } = mark;
    element.addEventListener("pointerdown", (event) => {
      event.stopPropagation();
      const own = this.nearest(event.clientX, event.clientY) ?? mark; // where targets overlap, the one that is meant
      if (this.start || event.button !== 0 || !event.isPrimary || !this.handles.grab(own.handle.id)) return;
      event.preventDefault(); // the focus goes to the one that is meant, too
      own.element.focus({ preventScroll: true });
      const at = this.viewer.toPage(own.handle.at_mm);
      this.start = { id: event.pointerId, x: event.clientX, y: event.clientY, dx: at.x - event.clientX, dy: at.y - event.clientY, moved: false };
      own.element.setPointerCapture(event.pointerId);
    });
    element.addEventListener("pointermove", (event) => {
      const { start } = this;
      if (event.pointerId !== start?.id) return;
      start.moved ||= Math.hypot(event.clientX - start.x, event.clientY - start.y) >= MOVED;
      const to = start.moved ? skinAt(this.viewer, this.scan, this.drawing.skin(), event.clientX + start.dx, event.clientY + start.dy) : null;
      if (to) this.handles.drag(to); // beside the body it stays where it was
    });
    const end = (event: PointerEvent): void => {
      if (event.pointerId !== this.start?.id) return;
      this.start = null;
      void this.handles.release();
    };
    element.addEventListener("pointerup", end);
    element.addEventListener("pointercancel", end);
    element.addEventListener("keydown", (event) => this.press(event, mark));
    element.addEventListener("blur", () => this.start === null && void this.handles.release());
  }

  /** The visible handle whose middle is next to page pixels. */
  private nearest(clientX: number, clientY: number): Mark | null {
    let best: { mark: Mark; away: number } | null = null;
    for (const mark of this.marks.values()) {
      const { x, y } = this.viewer.toPage(mark.handle.at_mm);
      const away = mark.element.classList.contains("is-hidden") ? Infinity : Math.hypot(x - clientX, y - clientY);
      if (away < (best?.away ?? Infinity)) best = { mark, away };
    }
    return (best as { mark: Mark } | null)?.mark ?? null;
  }

  private press(event: KeyboardEvent, mark: Mark): void {
    if (event.key === "Escape" && this.handles.isHeld()) {
      this.handles.cancel();
      event.preventDefault();
      event.stopPropagation();
      return;
    }
    const arrow = ARROWS[event.key];
    if (!arrow || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    event.stopPropagation();
    if (!this.handles.grab(mark.handle.id)) return;
    const mm = event.shiftKey ? FAR : 1;
    const grows = new Vector3(...(mark.handle.grows as Vector));
    if (grows.lengthSq() > 0) {
      const [from, to] = [this.viewer.toScreen(mark.point), this.viewer.toScreen(mark.point.clone().addScaledVector(grows, 0.01))];
      const along = (to.x - from.x) * arrow[0] + (to.y - from.y) * arrow[1];
      const across = Math.abs((to.x - from.x) * arrow[1] - (to.y - from.y) * arrow[0]);
      if (Math.abs(along) > 0.1 * across) this.handles.step(Math.sign(along) * mm);
      return;
    }
    const { x, y } = this.viewer.toPage(mark.handle.at_mm);
    const far = mm * this.pixelsPerMm(mark.point);
    const to = skinAt(this.viewer, this.scan, this.drawing.skin(), x + far * arrow[0], y + far * arrow[1]);
    if (to) this.handles.drag(to);
    this.handles.releaseSoon();
  }

  private pixelsPerMm(point: Vector3): number {
    const from = { ...this.viewer.toScreen(point) };
    const axes = [new Vector3(0.01, 0, 0), new Vector3(0, 0.01, 0), new Vector3(0, 0, 0.01)];
    const sizes = axes.map((axis) => {
      const to = this.viewer.toScreen(point.clone().add(axis));
      return Math.hypot(to.x - from.x, to.y - from.y) / 10;
    });
    return Math.max(...sizes);
  }

  private place(): void {
    for (const { element, handle, point, normal } of this.marks.values()) {
      const { x, y } = this.viewer.toScreen(point);
      element.style.translate = `${x.toFixed(1)}px ${y.toFixed(1)}px`;
      const isHeld = element.classList.contains("is-held");
      element.classList.toggle("is-hidden", !isHeld && isHidden(this.viewer, this.scan, point, normal));
      element.classList.toggle("is-left", handle.side === "L");
    }
  }
}
