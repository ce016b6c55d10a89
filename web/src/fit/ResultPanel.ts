// The last step: which landmarks to check, the model's shape, and the files to take away.
import { type Asked, openQuestions, sentenceOf } from "../landmarks/questions/questions";
import type { LandmarksSlice } from "../landmarks/state";
import type { PageSlice } from "../store/page";
import { only } from "../store/store";
import { el, fill, icon, show } from "../ui/dom";
import type { Panel } from "../ui/Panel";
import type { HandPoseActions } from "./hand_pose/handPoseActions";
import { createShapeSliders } from "./hand_pose/ShapeSliders";
import type { FitSlice } from "./state";
import * as text from "./text";

type Shown = Pick<PageSlice & LandmarksSlice & FitSlice, "meta" | "models" | "picks" | "certain" | "fit" | "handPose" | "followed"> & Pick<Asked, "scan">;

export function createResultPanel(handPose: HandPoseActions): Panel<Shown> {
  const sliders = createShapeSliders(handPose);
  const files = el("ul", { class: "files" });
  const downloads = el("div", {}, el("p", { class: "label" }, text.result.files), files);
  const list = el("ul", { class: "reasons" });
  const warnings = el("div", { class: "look-here", hidden: true }, el("p", { class: "label" }, text.result.warnings), list);
  const element = el("div", { class: "panel" }, warnings, sliders.element, downloads);
  return {
    element,
    select: only("meta", "models", "scan", "picks", "certain", "fit", "handPose", "followed"),
    update(state: Shown): void {
      const fit = state.fit;
      const isDone = fit?.state === "done";
      show(downloads, isDone);
      sliders.update(state);
      const sentences = isDone ? openQuestions(state).map((question) => sentenceOf(question, state.meta?.landmarks ?? [])) : [];
      show(warnings, sentences.length > 0);
      fill(list, sentences, () => sentences.map((sentence) => el("li", {}, sentence)));
      if (!fit) return;
      fill(files, fit.id, () =>
        text.result.downloads.map(({ key, name, what }) =>
          el("li", {}, el("a", { href: fit.links[key], download: name }, icon("download"), el("span", {}, name)), el("span", { class: "muted" }, what)),
        ),
      );
    },
  };
}
