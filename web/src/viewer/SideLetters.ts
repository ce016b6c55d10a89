// L and R beside the body, on the patient's own sides, turning with it: nobody has to think whose left is meant.
import { Vector3 } from "three";
import { el } from "../dom";
import type { Session } from "../state/session";
import { text } from "../text";
import type { Part, Viewer } from "./Viewer";

const AWAY = 0.05; // metres beside the body

export class SideLetters implements Part {
  private readonly letters = ([1, -1] as const).map((side) => ({
    side,
    element: el(
      "div",
      { class: `letter side-${side > 0 ? "left" : "right"}`, hidden: true },
      el("strong", {}, side > 0 ? "L" : "R"),
      el("span", {}, side > 0 ? text.view.left : text.view.right),
    ),
  }));

  constructor(private readonly viewer: Viewer) {
    viewer.overlay.append(...this.letters.map((letter) => letter.element));
    viewer.beforeFrame.add(() => this.place());
  }

  update(state: Session): void {
    for (const { element } of this.letters) element.hidden = state.scan === null;
  }

  private place(): void {
    const { half, body } = this.viewer;
    for (const { side, element } of this.letters) {
      const seen = new Vector3(side * (half.x + AWAY), 0.1 * half.y, 0);
      const { x, y, depth } = this.viewer.toScreen(body.worldToLocal(seen));
      const limit = this.viewer.host.clientWidth - 40;
      element.style.transform = `translate(${Math.min(Math.max(x, 40), limit).toFixed(1)}px, ${y.toFixed(1)}px)`;
      element.classList.toggle("is-far", depth > this.viewer.camera.position.length() + half.x * 0.5);
    }
  }
}
