// Puts the panels in their places.
import type { Actions } from "./actions";
import { READABLE } from "../scan/actions";
import type { OtherStage } from "../stances/OtherView";
import { isComparing } from "../stances/state";
import { el, setText, show } from "../ui/dom";
import type { Place, Session } from "./session";
import { text } from "../ui/text";
import { problem } from "../ui/controls";
import { createColourBar } from "../fit/ColourBar";
import { createDrawingPanel } from "../drawing/DrawingPanel";
import { createEmptyState } from "../scan/EmptyState";
import { createFitPanel } from "../fit/FitPanel";
import { createGuideCard } from "../landmarks/GuideCard";
import { createHelpDialog } from "./HelpDialog";
import { createLandmarkPanel } from "../landmarks/LandmarkPanel";
import { createNumbersPanel } from "../fit/NumbersPanel";
import { createResultPanel } from "../fit/ResultPanel";
import { createScanPanel } from "../scan/ScanPanel";
import { createShareDialog } from "../share/ShareDialog";
import { createSteps } from "./Steps";
import { createTimeline } from "../fit/TimelinePanel";
import { createOtherPane } from "../stances/OtherPane";
import { createStancesBar } from "../stances/StancesBar";
import { createStancesDialog } from "../stances/StancesDialog";
import { createMeasuresDialog } from "../stances/MeasuresDialog";
import { createTopBar } from "./TopBar";
import { createSwipe } from "../viewer/Swipe";
import { createViewBar } from "../viewer/ViewBar";

/** What the viewer needs of the page. */
export interface Stage {
  host: HTMLElement;
  canvas: HTMLCanvasElement;
  overlay: HTMLElement;
  picture: HTMLCanvasElement;
  light: HTMLElement;
  other: OtherStage;
}

export function createPage(actions: Actions, dismiss: (place: Place) => void) {
  const canvas = el("canvas", { class: "view", role: "application", "aria-label": text.view.canvas, tabindex: 0 });
  const overlay = el("div", { class: "overlay", "aria-hidden": "true" });
  const guide = createGuideCard(actions);
  const viewBar = createViewBar(actions);
  const colourBar = createColourBar();
  const swipe = createSwipe(actions);
  const empty = createEmptyState(actions, dismiss);
  const page = problem(() => dismiss("page"));
  const model = problem(() => dismiss("model"));
  const distances = problem(() => dismiss("distances"));
  const graphics = el("p", { class: "no-graphics", role: "alert", hidden: true });
  const host = el("main", { class: "stage" }, canvas, overlay, swipe.element, colourBar.element, viewBar.element, empty.element, page.element, model.element, distances.element, graphics);
  const veil = el("div", { class: "drop-veil", hidden: true }, el("p", {}, text.empty.drop));
  host.append(veil);
  acceptDrops(host, veil, actions);

  const steps = createSteps(actions, {
    scan: createScanPanel(actions, () => dismiss("scan")),
    landmarks: createLandmarkPanel(actions, () => dismiss("landmarks")),
    fit: createFitPanel(actions, () => dismiss("fit")),
    drawing: createDrawingPanel(actions, () => dismiss("drawing"), () => dismiss("fit")),
    result: createResultPanel(actions),
  });
  const numbers = createNumbersPanel();
  const aside = el("aside", { class: "aside" }, guide.element, numbers.element);
  const timeline = createTimeline(actions);
  const help = createHelpDialog(actions);
  const share = createShareDialog(actions, () => dismiss("share"));
  const top = createTopBar(actions);
  const stances = createStancesBar(actions);
  top.element.querySelector(".spring")!.before(stances.element);
  const adding = createStancesDialog(actions, () => dismiss("stances"));
  const measures = createMeasuresDialog(actions, () => dismiss("stances"));
  const other = createOtherPane(actions);
  host.append(other.caption);
  const version = el("span", { class: "muted" });
  const live = el("p", { class: "visually-hidden", role: "status", "aria-live": "polite" });
  const footer = el("footer", { class: "footer" }, el("strong", {}, text.notice), el("span", { class: "spring" }), version);
  const panels = [top, steps, guide, viewBar, colourBar, swipe, empty, numbers, timeline, help, share, stances, adding, measures, other];

  return {
    elements: [top.element, steps.element, host, other.element, aside, timeline.element, footer, help.element, share.element, adding.element, measures.element, live],
    stage: { host, canvas, overlay, picture: guide.canvas, light: guide.light, other: other.stage } satisfies Stage,
    update(state: Session): void {
      document.documentElement.dataset.theme = state.theme;
      document.body.classList.toggle("is-empty", state.scan === null);
      document.body.classList.toggle("has-timeline", (state.fit?.iterations.length ?? 0) > 0);
      document.body.classList.toggle("is-comparing", isComparing(state));
      document.body.classList.toggle("has-other", state.stances.other !== null);
      document.body.classList.toggle("is-second", state.stances.isSecond);
      host.classList.toggle("is-placing", state.active !== null);
      overlay.classList.toggle("is-numbered", state.step === "landmarks");
      overlay.classList.toggle("is-narrow", isComparing(state) || (state.fit !== null && state.overlay === "beside"));
      for (const panel of panels) panel.update(state);
      show(numbers.element, state.active === null);
      page.set(state.problems.page);
      model.set(state.problems.model);
      distances.set(state.problems.distances);
      show(graphics, state.graphics !== "ok");
      setText(graphics, state.graphics === "absent" ? text.errors.noGraphics : state.graphics === "lost" ? text.errors.graphicsLost : "");
      setText(version, state.meta ? text.version(state.meta.version) : "");
      setText(live, state.announcement);
    },
  };
}

/** A scan may be dropped anywhere on the canvas, also over one that is already there. */
function acceptDrops(host: HTMLElement, veil: HTMLElement, actions: Actions): void {
  const hasFile = (event: DragEvent): boolean => event.dataTransfer?.types.includes("Files") ?? false;
  addEventListener("dragover", (event) => hasFile(event) && event.preventDefault()); // else the browser opens the file
  addEventListener("drop", (event) => {
    event.preventDefault();
    show(veil, false);
  });
  host.addEventListener("dragenter", (event) => show(veil, hasFile(event)));
  veil.addEventListener("dragleave", () => show(veil, false));
  host.addEventListener("drop", (event) => {
    const files = [...(event.dataTransfer?.files ?? [])];
    const file = files.find((each) => READABLE.test(each.name)) ?? files[0];
    if (file) void actions.scan.upload(file);
  });
}
