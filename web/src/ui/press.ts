/**
 * Runs updates of the page, and those that come while a button is pressed once it is let go, of each panel the last: what
 * moves away from under the pointer meanwhile gets no click.
 */
export function betweenPresses(): (panel: object, update: () => void) => void {
  let isPressed = false;
  const waiting = new Map<object, () => void>();
  const letGo = (): void => {
    isPressed = false;
    for (const update of waiting.values()) update();
    waiting.clear();
  };
  addEventListener("pointerdown", ({ target }) => (isPressed = target instanceof Element && target.closest("button, a, label") !== null), { capture: true });
  addEventListener("click", () => (isPressed = false), { capture: true }); // what follows from it is seen at once
  for (const end of ["pointerup", "pointercancel"]) addEventListener(end, () => setTimeout(letGo), { capture: true });
  return (panel, update) => {
    if (isPressed) waiting.set(panel, update);
    else {
      waiting.delete(panel);
      update();
    }
  };
}
