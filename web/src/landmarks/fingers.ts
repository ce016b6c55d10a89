// A finger hides what it points at.  Held still on the body while a landmark is wanted, it gets a cross above its tip
// and the loupe; it then moves the cross, and lifting it places the landmark.  A tap places at once, a drag turns.
import type { Store } from "../store/store";
import type { Crosshair } from "../viewer/Crosshair";
import type { Viewer } from "../viewer/Viewer";
import type { LandmarkActions } from "./actions";
import type { LandmarksSlice } from "./state";

const HOLD_MS = 350; // longer than a tap, shorter than the browser's own menu
const STILL = 8; // pixels
const ABOVE = 56; // pixels from the finger's middle to the cross: clear of a fingertip

export function listenToFingers(canvas: HTMLElement, viewer: Viewer, cross: Crosshair, store: Store<LandmarksSlice>, landmarks: LandmarkActions): { isAimed: (event: PointerEvent) => boolean } {
  const aimed = new WeakSet<PointerEvent>(); // their lifting is no click
  let finger: { id: number; x: number; y: number; since: number; timer: ReturnType<typeof setTimeout>; isAiming: boolean } | null = null;
  /** By the events' own clock: on a busy page the timer may run before the finger's earlier move or lifting arrives. */
  const hasAimed = (event: PointerEvent): boolean => finger !== null && finger.isAiming && event.timeStamp - finger.since >= HOLD_MS;

  const end = (): void => {
    if (!finger) return;
    clearTimeout(finger.timer);
    if (finger.isAiming) {
      cross.hide();
      viewer.mayTurn = true;
    }
    finger = null;
  };

  canvas.addEventListener("pointerdown", (event) => {
    const isSecond = finger !== null; // two fingers move and zoom
    end();
    if (event.pointerType !== "touch" || isSecond || !event.isPrimary || store.get().active === null) return;
    const aim = (): void => {
      if (!finger) return;
      finger.isAiming = true;
      viewer.mayTurn = false;
      cross.show(finger.x, finger.y - ABOVE);
    };
    finger = { id: event.pointerId, x: event.clientX, y: event.clientY, since: event.timeStamp, timer: setTimeout(aim, HOLD_MS), isAiming: false };
  });
  canvas.addEventListener("pointermove", (event) => {
    if (event.pointerId !== finger?.id) return;
    if (hasAimed(event)) cross.show(event.clientX, event.clientY - ABOVE);
    else if (Math.hypot(event.clientX - finger.x, event.clientY - finger.y) > STILL) end();
  });
  // Before the click is looked for: lifting the finger places under the cross and not under the finger.
  canvas.addEventListener(
    "pointerup",
    (event) => {
      if (event.pointerId !== finger?.id) return;
      const isAimed = hasAimed(event);
      const { hit } = cross;
      end();
      if (!isAimed) return;
      aimed.add(event);
      if (hit) landmarks.place(hit.point);
    },
    { capture: true },
  );
  canvas.addEventListener("pointercancel", end);
  return { isAimed: (event) => aimed.has(event) };
}
