// L and R beside the body, on the patient's own sides, turning with it: nobody has to think whose left is meant.
import { Vector3 } from "three";
import { el } from "../ui/dom";
import type { Part, Viewer } from "./Viewer";

const AWAY = 26; // pixels beside the body
const HALF = 18; // of a letter, with air

export class SideLetters implements Part<{ readonly scan: object | null }> {
  private readonly letters = ([1, -1] as const).map((side) => ({
    side,
    element: el(
      "div",
      { class: `letter side-${side > 0 ? "left" : "right"}`, hidden: true },
      el("strong", {}, side > 0 ? "L" : "R"),
    ),
  }));

  constructor(private readonly viewer: Viewer) {
    viewer.overlay.append(...this.letters.map((letter) => letter.element));
    viewer.beforeFrame.add(() => this.place());
  }

  update({ scan }: { readonly scan: object | null }): void {
    for (const { element } of this.letters) element.hidden = scan === null;
  }

  private place(): void {
    const { half, body, gaze } = this.viewer;
    const height = 0.5 + 0.62 * gaze.x ** 4; // beside the shoulders; seen from the side above them, not over the body
    const middle = this.viewer.toScreen(body.worldToLocal(new Vector3())).x;
    for (const { side, element } of this.letters) {
      const seen = new Vector3(side * half.x, height * half.y, 0);
      const edge = this.viewer.toScreen(body.worldToLocal(seen));
      const limit = this.viewer.host.clientWidth - HALF;
      const outwards = Math.max(-1, Math.min(1, (edge.x - middle) / 30));
      const x = Math.min(Math.max(edge.x + AWAY * outwards, HALF), limit);
      element.style.transform = `translate(${x.toFixed(1)}px, ${Math.max(edge.y, 3 * HALF).toFixed(1)}px)`;
      element.classList.toggle("is-far", side * gaze.x < -0.55);
    }
  }
}
