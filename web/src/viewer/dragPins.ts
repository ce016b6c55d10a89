// A placed landmark is moved by dragging its mark over the skin, or by arrow keys while it is the wanted one.
// The mark follows the pointer at once; the state learns of it when the mark is let go.
import type { Actions } from "../actions";
import type { Vector } from "../api/types";
import type { Session } from "../state/session";
import type { Store } from "../state/store";
import type { LandmarkPins } from "./LandmarkPins";
import { pickAt } from "./picking";
import type { ScanMesh } from "./ScanMesh";
import type { Viewer } from "./Viewer";

const MOVED = 3; // pixels; less is a click
const ARROWS: Record<string, readonly [number, number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
const FAST = 5; // times as far with Shift

export function listenToDrags(canvas: HTMLElement, viewer: Viewer, scan: ScanMesh, pins: LandmarkPins, store: Store<Session>, actions: Actions): void {
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
      const isFree = held === null && event.button === 0 && event.isPrimary && store.get().active === null && store.get().drawn.tool === "none";
      const name = isFree ? pins.at(event.clientX, event.clientY) : null;
      if (name === null) return;
      held = { name, id: event.pointerId, x: event.clientX, y: event.clientY, point: null };
      viewer.mayTurn = false;
      canvas.setPointerCapture(event.pointerId);
    },
    { capture: true },
  );
  canvas.addEventListener("pointermove", (event) => {
    if (!held) {
      if (event.buttons === 0) canvas.classList.toggle("is-over-pin", store.get().active === null && pins.at(event.clientX, event.clientY) !== null);
      return;
    }
    if (event.pointerId !== held.id || (!held.point && Math.hypot(event.clientX - held.x, event.clientY - held.y) < MOVED)) return;
    held.point = pickAt(viewer, scan, event.clientX, event.clientY)?.point ?? held.point; // beside the body it stays where it was
    if (held.point) pins.hold(held.name, held.point);
  });
  canvas.addEventListener("pointerup", (event) => {
    if (event.pointerId !== held?.id) return;
    const { name, point } = held;
    letGo();
    if (point) void actions.moveLandmark(name, point);
  });
  canvas.addEventListener("pointercancel", letGo);

  canvas.addEventListener("keydown", (event) => {
    const arrow = ARROWS[event.key];
    const { active, picks } = store.get();
    const point = active === null ? undefined : picks.present[active];
    if (!arrow || active === null || !point) return;
    event.preventDefault();
    const at = viewer.toPage(point);
    const far = event.shiftKey ? FAST : 1;
    const hit = pickAt(viewer, scan, at.x + far * arrow[0], at.y + far * arrow[1]);
    if (hit) actions.landmarks.move(active, hit.point);
  });
}
