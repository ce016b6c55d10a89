// The view by keys while it has the focus: arrows turn the body, plus and minus zoom.
import type { Viewer } from "./Viewer";

export const ARROWS: Readonly<Record<string, readonly [number, number]>> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
const FAST = 5; // times as far with Shift
const TURN_DEGREES = 5;
const ZOOM = 1.15;

/**
 * `press` is given the key and how far it goes, and says whether it meant something: then neither those that listen after
 * it nor the page's own keys hear of it.
 */
export function onCanvasKey(canvas: HTMLElement, press: (key: string, far: number) => boolean): void {
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || !press(event.key, event.shiftKey ? FAST : 1)) return;
    event.preventDefault();
    event.stopImmediatePropagation();
  });
}

/** `hasBody`: there is something to look at. */
export function listenToViewKeys(canvas: HTMLElement, viewer: Viewer, hasBody: () => boolean): void {
  onCanvasKey(canvas, (key, far) => {
    if (!hasBody()) return false;
    const arrow = ARROWS[key];
    if (key === "+" || key === "=" || key === "-") viewer.zoomBy(key === "-" ? ZOOM : 1 / ZOOM);
    else if (arrow) viewer.turnBy(far * TURN_DEGREES * arrow[0], far * TURN_DEGREES * arrow[1]);
    else return false;
    return true;
  });
}
