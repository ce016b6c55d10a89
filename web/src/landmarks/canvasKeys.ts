// Placing a landmark by keys while the view has the focus: arrows move the cross of a wanted landmark and Enter places it;
// they nudge one that is placed along the skin.
import type { Vector } from "../api/types";
import type { ScanSlice } from "../scan/state";
import type { PageSlice } from "../store/page";
import { only, type Store } from "../store/store";
import type { Crosshair } from "../viewer/Crosshair";
import { ARROWS, onCanvasKey } from "../viewer/keys";
import { pickAt, type Surface } from "../viewer/picking";
import type { Viewer } from "../viewer/Viewer";
import type { LandmarkActions } from "./actions";
import { openProposals } from "./proposals/proposals";
import type { LandmarksSlice } from "./state";
import * as text from "./text";

const CROSS_PX = 6; // a hand's breadth in ten presses, finer than the marks are large
const NUDGE_PX = 1;

export function listenToLandmarkKeys(canvas: HTMLElement, viewer: Viewer, scan: Surface, cross: Crosshair, store: Store<PageSlice & ScanSlice & LandmarksSlice>, landmarks: LandmarkActions): void {
  /** Where the wanted landmark is proposed, else in the middle: there the first arrow finds the cross. */
  function begin(active: string): void {
    const { proposals, picks } = store.get();
    const proposal = openProposals(proposals, picks.present).find(({ name }) => name === active);
    viewer.settle();
    const box = viewer.host.getBoundingClientRect();
    const at = proposal ? viewer.toPage(proposal.point) : { x: box.left + box.width / 2, y: box.top + box.height / 2 };
    cross.show(at.x, at.y);
  }

  function nudge(active: string, point: Vector, across: number, down: number): void {
    const at = viewer.toPage(point);
    const hit = pickAt(viewer, scan, at.x + across, at.y + down);
    if (hit) landmarks.move(active, hit.point);
  }

  function placeHere(): void {
    const { hit } = cross;
    if (!hit) return store.set({ announcement: text.landmarks.noSkin });
    landmarks.place(hit.point);
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
    if (!there || active === null) return false;
    const arrow = ARROWS[key];
    if (key === "Enter" && cross.isShown) placeHere();
    else if (key === "Enter" && !(active in picks.present)) begin(active);
    else if (!arrow) return false;
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
  store.select(only("active"), ({ active }) => {
    if (!isByKeys) return;
    if (active === null) {
      if (document.activeElement === canvas) giveBack(before);
    } else {
      if (document.activeElement !== canvas) before = document.activeElement;
      canvas.focus();
      if (active in store.get().picks.present) cross.hide();
      else begin(active);
    }
  });

  onCanvasKey(canvas, press);
  canvas.addEventListener("blur", () => cross.hide());
  canvas.addEventListener("pointermove", (event) => event.pointerType === "mouse" && cross.hide());
}
