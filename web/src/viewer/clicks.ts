// A click, as against the start of a turn of the view: pressed and released within six pixels, one pointer, left button.

const STILL = 6; // pixels

export function onClick(target: HTMLElement, clicked: (event: PointerEvent) => void): void {
  let start: PointerEvent | null = null;
  let pointers = 0;
  const isStill = (event: PointerEvent): boolean =>
    start !== null && Math.hypot(event.clientX - start.clientX, event.clientY - start.clientY) < STILL;

  target.addEventListener("pointerdown", (event) => {
    pointers += 1;
    start = pointers === 1 && event.button === 0 ? event : null;
  });
  target.addEventListener("pointermove", (event) => {
    if (start?.pointerId === event.pointerId && !isStill(event)) start = null;
  });
  target.addEventListener("pointerup", (event) => {
    pointers = Math.max(0, pointers - 1);
    const isClick = start?.pointerId === event.pointerId && isStill(event);
    start = null;
    if (isClick) clicked(event);
  });
  target.addEventListener("pointercancel", () => {
    pointers = Math.max(0, pointers - 1);
    start = null;
  });
}
