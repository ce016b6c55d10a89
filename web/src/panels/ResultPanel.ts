// Step 4: the drawing's parts and the files to take away.
import type { Actions } from "../actions";
import { el, fill, icon, setText, show } from "../dom";
import { doubtSentences, labelsOf } from "../state/doubts";
import type { Session } from "../state/session";
import { text } from "../text";
import type { Panel } from "./Panel";
import { createShapeSliders } from "./ShapeSliders";

const plainStart = (label: string): string => label.charAt(0).toUpperCase() + label.slice(1);

export function createResultPanel(actions: Actions): Panel {
  const sliders = createShapeSliders(actions);
  const shapes = el("ul", { class: "shapes" });
  const note = el("p", { class: "muted small" });
  const files = el("ul", { class: "files" });
  const drawing = el("div", {}, el("p", { class: "label" }, text.result.drawing), shapes, note);
  const downloads = el("div", {}, el("p", { class: "label" }, text.result.files), files);
  const doubted = el("ul", { class: "reasons" });
  const doubts = el("div", { class: "look-here", hidden: true }, el("p", { class: "label" }, text.result.doubts), doubted);
  const element = el("div", { class: "panel" }, doubts, drawing, sliders.element, downloads);
  return {
    element,
    update(state: Session): void {
      const fit = state.fit;
      const isDone = fit?.state === "done";
      show(downloads, isDone);
      sliders.update(state);
      const sentences = isDone ? doubtSentences(fit, labelsOf(state.meta?.landmarks)) : [];
      show(doubts, sentences.length > 0);
      fill(doubted, sentences, () => sentences.map((sentence) => el("li", {}, sentence)));
      const model = state.model?.side.drawings.find((each) => each.name === fit?.drawingName);
      const names = fit?.drawing?.shapes.map((shape) => model?.shapes.find((each) => each.name === shape.name)?.label ?? shape.name).map(plainStart) ?? [];
      fill(shapes, names, () => names.map((name) => el("li", {}, el("span", { class: "stroke", "aria-hidden": "true" }), name)));
      const hasBridges = fit?.drawing?.shapes.some((shape) => shape.bridged?.includes(true)) ?? false;
      setText(note, fit && fit.drawingName === null ? text.result.noDrawing : hasBridges ? text.result.shapeNote : "");
      if (!fit) return;
      fill(files, fit.id, () =>
        text.result.downloads.map(({ key, name, what }) =>
          el("li", {}, el("a", { href: fit.links[key], download: name }, icon("download"), el("span", {}, name)), el("span", { class: "muted" }, what)),
        ),
      );
    },
  };
}
