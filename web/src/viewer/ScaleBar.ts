// A bar of so many centimetres at the foot of each pane, as long as they are where the eye looks: a wrong unit is seen at once.
import { el, setText } from "../ui/dom";
import * as text from "./text";
import type { Part, Viewer } from "./Viewer";

const LENGTHS_CM = [0.5, 1, 2, 4, 5, 10, 20, 50, 100];
const MOST = 120; // pixels

export class ScaleBar implements Part<{ readonly scan: object | null }> {
  private readonly words = el("span", {});
  private readonly element = el("div", { class: "scale-bar", hidden: true }, this.words);

  constructor(private readonly viewer: Viewer) {
    viewer.overlay.append(this.element);
    viewer.beforeFrame.add(() => this.measure());
  }

  update({ scan }: { readonly scan: object | null }): void {
    this.element.hidden = scan === null;
  }

  private measure(): void {
    const perCm = this.viewer.pixelsPerMetre / 100;
    const cm = LENGTHS_CM.findLast((length) => length * perCm <= MOST) ?? LENGTHS_CM[0]!;
    this.element.style.width = `${(cm * perCm).toFixed(1)}px`;
    setText(this.words, text.view.scale(cm));
  }
}
