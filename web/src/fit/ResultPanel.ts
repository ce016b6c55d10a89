// The last step: what the fit doubts, the model's shape, and the files to take away.
import type { Actions } from "../app/actions";
import { el, fill, icon, show } from "../ui/dom";
import { doubtSentences, labelsOf } from "./landmarkWarnings";
import type { Session } from "../app/session";
import { text } from "../ui/text";
import type { Panel } from "../ui/Panel";
import { createShapeSliders } from "./ShapeSliders";

export function createResultPanel(actions: Actions): Panel {
  const sliders = createShapeSliders(actions);
  const files = el("ul", { class: "files" });
  const downloads = el("div", {}, el("p", { class: "label" }, text.result.files), files);
  const doubted = el("ul", { class: "reasons" });
  const doubts = el("div", { class: "look-here", hidden: true }, el("p", { class: "label" }, text.result.doubts), doubted);
  const element = el("div", { class: "panel" }, doubts, sliders.element, downloads);
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
      if (!fit) return;
      fill(files, fit.id, () =>
        text.result.downloads.map(({ key, name, what }) =>
          el("li", {}, el("a", { href: fit.links[key], download: name }, icon("download"), el("span", {}, name)), el("span", { class: "muted" }, what)),
        ),
      );
    },
  };
}
