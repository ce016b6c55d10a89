// Everything that the mouse does on the body, by keys while the view has the focus: arrows move the cross of a wanted
// landmark and Enter places it; they nudge one that is placed along the skin; otherwise they turn the body.
import type { Actions } from "../app/actions";
import type { Vector } from "../api/types";
import { ghostsOf } from "./proposals";
import type { Session } from "../app/session";
import type { Store } from "../store/store";
import { text } from "../ui/text";
import type { Crosshair } from "../viewer/Crosshair";
import { pickAt } from "../viewer/picking";
import type { ScanMesh } from "../scan/ScanMesh";
import type { Viewer } from "../viewer/Viewer";

const ARROWS: Record<string, readonly [number, number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
const FAST = 5; // times as far with Shift
const CROSS_PX = 6; // a hand's breadth in ten presses, finer than the marks are large
const NUDGE_PX = 1;
const TURN_DEGREES = 5;
const ZOOM = 1.15;

export function listenToCanvasKeys(canvas: HTMLElement, viewer: Viewer, scan: ScanMesh, cross: Crosshair, store: Store<Session>, actions: Actions): void {
  /** Where the wanted landmark is proposed, else in the middle: there the first arrow finds the cross. */
  function begin(active: string): void {
    const { proposals, picks } = store.get();
    const ghost = ghostsOf(proposals, picks.present).find(({ name }) => name === active);
    const box = viewer.host.getBoundingClientRect();
    const at = ghost ? viewer.toPage(ghost.point) : { x: box.left + box.width / 2, y: box.top + box.height / 2 };
    cross.show(at.x, at.y);
  }

  function nudge(active: string, point: Vector, across: number, down: number): void {
    const at = viewer.toPage(point);
    const hit = pickAt(viewer, scan, at.x + across, at.y + down);
    if (hit) actions.landmarks.move(active, hit.point);
  }

  function placeHere(): void {
    const { hit } = cross;
    if (!hit) return actions.page.announce(text.landmarks.noSkin);
    actions.landmarks.place(hit.point);
  }

  /** To whom had the focus, or to what comes next when that has gone. */
  function giveBack(to: Element | null): void {
    queueMicrotask(() => {
      const isThere = to instanceof HTMLElement && to.isConnected && to.checkVisibility() && to !== document.body;
      (isThere ? to : document.getElementById("next"))?.focus();
    });
  }

  /** True when the key meant something here. */
  function press(key: string, far: number): boolean {
    const { active, picks, scan: there } = store.get();
    if (!there) return false;
    const arrow = ARROWS[key];
    if (key === "+" || key === "=" || key === "-") viewer.zoomBy(key === "-" ? ZOOM : 1 / ZOOM);
    else if (key === "Enter" && active !== null && cross.isShown) placeHere();
    else if (key === "Enter" && active !== null && !(active in picks.present)) begin(active);
    else if (!arrow) return false;
    else if (active === null) viewer.turnBy(far * TURN_DEGREES * arrow[0], far * TURN_DEGREES * arrow[1]);
    else if (active in picks.present) nudge(active, picks.present[active]!, far * NUDGE_PX * arrow[0], far * NUDGE_PX * arrow[1]);
    else {
      if (!cross.isShown) begin(active);
      cross.moveBy(far * CROSS_PX * arrow[0], far * CROSS_PX * arrow[1]);
    }
    return true;
  }

  // Who asks for a landmark by keys goes on by keys: the view gets the focus, and gives it back in the end.
  let isByKeys = false;
  let before: Element | null = null;
  addEventListener("keydown", () => (isByKeys = true), { capture: true });
  addEventListener("pointerdown", () => (isByKeys = false), { capture: true });
  store.subscribe(({ active, picks }, { active: previous }) => {
    if (active === previous || !isByKeys) return;
    if (active === null) {
      if (document.activeElement === canvas) giveBack(before);
    } else {
      if (document.activeElement !== canvas) before = document.activeElement;
      canvas.focus();
      if (active in picks.present) cross.hide();
      else begin(active);
    }
  });

  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || !press(event.key, event.shiftKey ? FAST : 1)) return;
    event.preventDefault();
    event.stopPropagation();
  });
  canvas.addEventListener("blur", () => cross.hide());
  canvas.addEventListener("pointermove", (event) => event.pointerType === "mouse" && cross.hide());
}
