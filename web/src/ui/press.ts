/**
 * Runs updates of the page, and those that come while a button within an element is pressed once it is let go, of each panel
 * the last: what moves away from under the pointer meanwhile gets no click.
 */
export function betweenPresses(within: HTMLElement): (panel: object, update: () => void) => void {
  let waiting: Map<object, () => void> | null = null;
  const letGo = (): void => {
    const updates = waiting?.values() ?? [];
    waiting = null;
    for (const update of updates) update();
  };
  within.addEventListener("pointerdown", ({ target }) => {
    if ((target as Element).closest("button, a, label")) waiting = new Map();
  });
  addEventListener("click", letGo, { capture: true }); // what follows from it is seen at once
  for (const end of ["pointerup", "pointercancel"]) addEventListener(end, () => setTimeout(letGo));
  return (panel, update) => (waiting ? void waiting.set(panel, update) : update());
}
