// A placed landmark is moved by dragging its mark over the skin.
// The mark follows the pointer at once, and the model of a fit with it; the state learns of it when the mark is let go.
import type { Vector } from "../api/types";
import { pickAt, type Surface } from "../viewer/picking";
import type { Viewer } from "../viewer/Viewer";
import type { LandmarkActions } from "./actions";
import type { LandmarkPins } from "./LandmarkPins";

/** What follows a mark while it is dragged: taken up, here now, and back where it was. */
export interface DragFollower {
  readonly begin: () => void;
  readonly move: (elsewhere: Record<string, Vector>) => void;
  readonly giveUp: () => void;
}

const MOVED = 3; // pixels; less is a click

/** `isFree`: no tool and no wanted landmark claims the pointer. */
export function listenToDrags(canvas: HTMLElement, viewer: Viewer, scan: Surface, pins: LandmarkPins, isFree: () => boolean, landmarks: LandmarkActions, follower: DragFollower): void {
  let held: { name: string; id: number; x: number; y: number; point: Vector | null } | null = null;

  const letGo = (): void => {
    if (held) pins.hold(null, null);
    held = null;
    viewer.mayTurn = true;
  };

  // Before the view's own controls hear of it: a drag that starts on a mark does not turn the body.
  canvas.addEventListener(
    "pointerdown",
    (event) => {
      const isStart = held === null && event.button === 0 && event.isPrimary && isFree();
      const name = isStart ? pins.at(event.clientX, event.clientY) : null;
      if (name === null) return;
      held = { name, id: event.pointerId, x: event.clientX, y: event.clientY, point: null };
      viewer.mayTurn = false;
      follower.begin();
      canvas.setPointerCapture(event.pointerId);
    },
    { capture: true },
  );
  canvas.addEventListener("pointermove", (event) => {
    if (!held) {
      if (event.buttons === 0) canvas.classList.toggle("is-over-pin", isFree() && pins.at(event.clientX, event.clientY) !== null);
      return;
    }
    if (event.pointerId !== held.id || (!held.point && Math.hypot(event.clientX - held.x, event.clientY - held.y) < MOVED)) return;
    held.point = pickAt(viewer, scan, event.clientX, event.clientY)?.point ?? held.point; // beside the body it stays where it was
    if (!held.point) return;
    pins.hold(held.name, held.point);
    follower.move({ [held.name]: held.point });
  });
  canvas.addEventListener("pointerup", (event) => {
    if (event.pointerId !== held?.id) return;
    const { name, point } = held;
    letGo();
    if (point) landmarks.move(name, point);
    else follower.giveUp();
  });
  canvas.addEventListener("pointercancel", () => {
    if (held) follower.giveUp();
    letGo();
  });
}
