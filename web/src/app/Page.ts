// Puts the panels in their places: top bar, strip, stage with its bar, side panel.
import { ApiError } from "../api/client";
import { noService } from "../api/text";
import { type Doubtful, openDoubt } from "../checks/doubts";
import { asksOf } from "../checks/state";
import { createTools } from "../drawing/Tools";
import { areSlicesOpen } from "../drawing/slices/state";
import { createColourBar } from "../fit/distances/ColourBar";
import { createMirrorLegend, hasMirror } from "../drawing/mirror/MirrorLegend";
import { createFitPanel } from "../fit/FitPanel";
import { outdated } from "../fit/outdated";
import { linesOn } from "../fit/verdict";
import { viewBarShown } from "../fit/state";
import { createTimeline } from "../fit/playback/TimelinePanel";
import { createGuideCard } from "../landmarks/GuideCard";
import { pickCount } from "../landmarks/state";
import { createHome } from "../patients/Home";
import { createPlanNotice } from "../plan/PlanNotice";
import { createLoadingCard } from "../scan/LoadingCard";
import { createScanPanel } from "../scan/ScanPanel";
import { hasLoose } from "../scan/state";
import { drop as dropWords } from "../scan/text";
import { createDrawingCarry } from "../stances/DrawingCarry";
import { createOtherPane } from "../stances/OtherPane";
import { createStrip } from "../stances/Strip";
import { hasInside, isComparing } from "../stances/state";
import type { Place } from "../store/page";
import { only, type Store } from "../store/store";
import { problem } from "../ui/controls";
import { el, setText, show } from "../ui/dom";
import { later } from "../ui/later";
import type { Panel } from "../ui/Panel";
import { betweenPresses } from "../ui/press";
import { errors, view as viewText } from "../viewer/text";
import { createViewBar, type ViewBarShown } from "../viewer/ViewBar";
import type { Stage } from "../viewer/Viewer";
import type { Actions } from "./actions";
import { addressOfPatient } from "./address";
import { createBodyPanel } from "./frame/BodyPanel";
import { createDeletionNotice } from "./deletion/DeletionNotice";
import { createLeaveDialog } from "./LeaveDialog"; // not loaded later: it comes when the service does not answer
import { createNextButton } from "./NextButton";
import type { HandOverShown } from "./handover/HandOver";
import type { PaperShown } from "./handover/Paper";
import type { Session } from "./session";
import { createSidePanel } from "./frame/SidePanel";
import { createTopBar } from "./frame/TopBar";
import { createUnsavedBar } from "./frame/UnsavedBar";

/** What the 3D view needs of the page. */
export interface Stages {
  readonly main: Stage;
  readonly other: Stage;
  /** where the wanted landmark is shown on the model, and the mark on it */
  readonly picture: HTMLCanvasElement;
  readonly light: HTMLElement;
}

export interface Page {
  readonly elements: readonly HTMLElement[];
  readonly stages: Stages;
  /** Where lines found on the skin are listed. */
  readonly ink: { readonly scan: HTMLElement; readonly drawing: HTMLElement };
  /** From now on the page shows what is in the store. */
  follow(store: Store<Session>): void;
}

type On = <Shown extends object>(panel: Panel<Shown, Session>) => void;

const UNDONE_MS = 6000; // so long what undo has changed stands over the body

export function createPage(actions: Actions, dismiss: (place: Place) => void): Page {
  const canvas = el("canvas", { class: "view", role: "application", "aria-label": viewText.canvas, tabindex: 0 });
  const overlay = el("div", { class: "overlay", "aria-hidden": "true" });
  const guide = createGuideCard(actions.landmarks);
  const tools = createTools(actions.drawing);
  const looks = { distances: actions.fit.showDistances, mirror: actions.fit.showMirror, relief: actions.scan.showRelief, loose: actions.scan.showLoose, colours: actions.scan.showColours, linked: actions.stances.link, slices: actions.drawing.showSlices };
  const viewBar = createViewBar(actions.view, looks, shownInViewBar, tools.element);
  const colourBar = createColourBar();
  const loading = createLoadingCard();
  const home = createHome(actions.patients, { files: (files) => void actions.bring.files(files), examples: (names) => void actions.bring.examples(names) }, addressOfPatient, dismiss);
  const page = problem(() => dismiss("page"));
  const model = problem(() => dismiss("model"));
  const distances = problem(() => dismiss("distances"));
  const refit = problem(() => dismiss("fit")); // of a fit that was asked for from another step
  const graphics = el("p", { class: "no-graphics", role: "alert", hidden: true });
  const host = el("div", { class: "stage" }, canvas, overlay, colourBar.element, model.element, distances.element, refit.element);
  const canvasBar = later(
    only("problems", "drawn", "isCanvasFull", "hasPen", "fingersDraw"),
    ({ isCanvasFull }: Pick<Session, "problems" | "drawn" | "isCanvasFull" | "hasPen" | "fingersDraw">) => isCanvasFull,
    async () => (await import("../drawing/pen/CanvasBar")).createCanvasBar(actions.drawing, actions.view.from, () => dismiss("drawing")),
  );
  const mirror = createMirrorLegend();
  host.append(canvasBar.element, mirror.element);
  const veil = el("div", { class: "drop-veil", hidden: true }, el("p", {}, dropWords));
  acceptDrops(veil, actions);

  const scan = createScanPanel({ ...actions.scan, takeSegments: actions.bring.takeSegments }, () => dismiss("scan"), isUntouched);
  const fit = createFitPanel(actions.fit, () => dismiss("fit"));
  const carry = createDrawingCarry(actions.stances);
  const ink = { scan: el("div", {}), drawing: el("div", {}) }; // lines found on the skin, see ink/open.ts
  // What the first page does not show comes with the first scan.
  const late: { readonly place: HTMLElement; readonly load: (on: On) => Promise<void> }[] = [];
  const withScan = <Shown extends object>(load: () => Promise<Panel<Shown, Session>>): { readonly element: HTMLElement } => {
    const place = el("div", {});
    late.push({
      place,
      async load(on) {
        const panel = await load();
        place.append(panel.element);
        on(panel);
      },
    });
    return { element: place };
  };
  const landmarks = withScan(async () => (await import("../landmarks/LandmarkPanel")).createLandmarkPanel(actions.landmarks, actions.proposals, () => dismiss("landmarks")));
  const found = withScan(async () => (await import("../stances/found/FoundBox")).createFoundBox(actions.found));
  const plan = withScan(async () => (await import("../drawing/panel/PlanPanel")).createPlanPanel(actions.drawing, actions.plan, () => dismiss("drawing"), ink.drawing, carry.element));
  const handOver = later(
    only("asked", "meta", "step", "loading", "scan", "confirmed", "picks", "certain", "proposals", "skipped", "active", "fit", "isStarting", "stance", "preset", "refine", "drawing", "drawn", "ink", "stances", "checks", "overlay"),
    ({ step, scan }: HandOverShown) => step === "handover" && scan !== null,
    async () => (await import("./handover/HandOver")).createHandOver(actions),
  );
  const paper = later(
    only("step", "scan", "fit", "drawn", "stances"),
    ({ step, scan }: PaperShown) => step === "handover" && scan !== null,
    async () => (await import("./handover/Paper")).createPaper(),
  );
  const next = createNextButton(actions);
  const setPoints = (): void => {
    actions.page.goTo("points");
    actions.landmarks.wantNext();
  };
  const numbers = later(
    (state: Session) => ({ meta: state.meta, fit: state.fit, old: outdated(state), lines: linesOn(state), asks: asksOf(state) }),
    ({ fit }) => fit !== null,
    async () => (await import("../fit/distances/NumbersPanel")).createNumbersPanel<Session>({ outdated, asks: asksOf, again: () => void actions.fit.start(), anotherFile: (file) => void actions.bring.files([file]), setPoints, giveLength: () => giveLength() }),
  );
  const check = later(
    only("meta", "checks"),
    ({ checks }: Pick<Session, "meta" | "checks">) => checks.tour !== null,
    async () => (await import("../checks/CheckCard")).createCheckCard(actions.checks),
  );
  const doubt = later(
    only("asked", "scan", "confirmed", "drawn", "stances", "problems", "stance", "fit"),
    (state: Doubtful & Pick<Session, "problems" | "stance">) => openDoubt(state) !== null,
    async () => (await import("../checks/DoubtCard")).createDoubtCard({ ...actions, size: { isRight: actions.bring.sizeIsRight, is: (units) => void actions.bring.again({ units }), anotherFile: (file) => void actions.bring.files([file]), measure: giveLength } }),
  );
  const size = withScan(async () => (await import("../landmarks/size/SizeRow")).createSizeRow(actions.size));
  /** Where a measured length is given, and the clicks that it takes. */
  const giveLength = (): void => {
    actions.scan.confirm(); // the size is not asked about any more
    actions.page.goTo("body");
    (document.getElementById("details") as HTMLDetailsElement).open = true;
    actions.size.measure();
    size.element.scrollIntoView({ block: "nearest" });
  };
  const sentence = withScan(async () => (await import("./frame/Sentence")).createSentence(actions));
  const timeline = createTimeline(actions.player);
  const side = createSidePanel(
    {
      body: createBodyPanel(() => actions.page.goTo("points"), [sentence.element, ink.scan, scan.asked, fit.element, numbers.element], [timeline.element, scan.element, size.element, fit.settings]),
      points: el("div", { class: "panel" }, guide.element, landmarks.element, found.element),
      plan: plan.element,
      handover: handOver.element,
    },
    next.element,
    [check.element, doubt.element],
  );
  const help = later(only("isHelpOpen"), ({ isHelpOpen }: Pick<Session, "isHelpOpen">) => isHelpOpen, async () => (await import("./help/HelpDialog")).createHelpDialog(actions));
  const share = later(
    only("problems", "share"),
    (state: Pick<Session, "problems" | "share">) => state.share.isOpen,
    async () => (await import("../share/ShareDialog")).createShareDialog(actions.share, () => dismiss("share")),
  );
  const leave = createLeaveDialog(actions.leaving);
  const deleting = later(
    only("isAskingToDelete", "scan", "picks", "drawn", "drawing", "fit", "meta", "stances"),
    ({ isAskingToDelete }: Pick<Session, "isAskingToDelete" | "scan" | "picks" | "drawn" | "drawing" | "fit" | "meta" | "stances">) => isAskingToDelete,
    async () => (await import("./deletion/DeleteDialog")).createDeleteDialog(actions.deletion),
  );
  const deleted = createDeletionNotice(actions.deletion);
  const changed = createPlanNotice(actions.plan);
  const unsaved = createUnsavedBar(() => actions.unsaved.soon());
  const strip = createStrip({ ...actions.stances, visits: () => actions.visits.open() }, (state: Session, fit) => (state.checks.of[fit]?.worth_it ? state.checks.of[fit].checks.length : 0));
  const top = createTopBar(actions);
  const adding = later(
    only("examples", "problems", "scan", "stance", "fit", "stances"),
    ({ stances }: Pick<Session, "examples" | "problems" | "scan" | "stance" | "fit" | "stances">) => stances.isAdding,
    async () => (await import("../stances/StancesDialog")).createStancesDialog(actions.stances, () => dismiss("stances")),
  );
  const measures = later(
    only("meta", "problems", "scan", "fit", "stances"),
    ({ stances }: Pick<Session, "meta" | "problems" | "fit" | "stances">) => stances.measures.isOpen,
    async () => (await import("../stances/measures/MeasuresDialog")).createMeasuresDialog(actions.stances, () => dismiss("stances")),
  );
  const visits = later(only("problems", "scan", "stances"), ({ stances }: Pick<Session, "problems" | "scan" | "stances">) => stances.visits.isOpen, async () => (await import("../stances/visits/VisitsDialog")).createVisitsDialog(actions.visits, () => dismiss("stances")));
  const other = createOtherPane(actions.stances);
  host.append(other.caption);
  const live = el("p", { class: "visually-hidden", role: "status", "aria-live": "polite" });
  const undone = el("p", { class: "undone", role: "status", "aria-live": "polite" }); // each saying is an element of its own: the same one twice is read out twice
  const slices = later(
    only("step", "scan", "picks", "active", "isCropping", "isCanvasFull", "stance", "fit", "drawn", "lesion", "slices", "stances", "checks"),
    areSlicesOpen,
    async () => (await import("../stances/slices/SlicesPanel")).createSlices({ slices: (change) => actions.drawing.slices(change), lesions: (own) => actions.plan.lesions(own), choose: (item) => actions.drawing.chooseItem(item), volume: (of) => actions.scan.volume(of) }),
  );
  paper.element.className = "paper-host";
  const stages = el("main", { class: "stages" }, host, other.element, slices.element, viewBar.element, paper.element, home.element, loading.element, page.element, graphics, deleted.element, changed.element, undone);

  return {
    elements: [top.element, strip.element, stages, side.element, veil, help.element, share.element, adding.element, measures.element, visits.element, leave.element, deleting.element, unsaved.element, live],
    ink,
    stages: { main: { host, canvas, overlay }, other: other.stage, picture: guide.canvas, light: guide.light },
    follow(store): void {
      // Classes first: where a panel stands and whether it is seen decides what it can scroll to or focus.
      store.select(only("theme", "asked", "scan", "confirmed", "fit", "active", "step", "drawn", "stances", "checks"), (state) => {
        document.documentElement.dataset.theme = state.theme;
        const isAsked = openDoubt(state) !== null;
        document.body.classList.toggle("is-empty", state.scan === null);
        document.body.classList.toggle("is-checking", isAsked || state.checks.tour !== null);
        document.body.classList.toggle("is-asked", isAsked);
        document.body.classList.toggle("is-comparing", isComparing(state));
        document.body.classList.toggle("is-second", state.stances.isSecond);
        host.classList.toggle("is-placing", state.active !== null);
        overlay.classList.toggle("is-numbered", state.step === "points");
      });
      const run = betweenPresses(side.element);
      const on: On = (panel) =>
        void store.select((state) => panel.select(state), (shown) => run(panel, () => panel.update(shown)));
      let hasCome = false;
      store.select(only("scan"), ({ scan }) => {
        if (hasCome || !scan) return;
        hasCome = true;
        for (const { load } of late) void load(on).catch(() => reportError(new ApiError(noService, 0))); // the page says it
      });
      on(top);
      on(strip);
      on(tools);
      on(side);
      on(scan);
      on(fit);
      on(canvasBar);
      on(mirror);
      on(carry);
      on(handOver);
      on(paper);
      on(next);
      on(guide);
      on(viewBar);
      on(colourBar);
      on(home);
      on(loading);
      on(numbers);
      on(check);
      on(doubt);
      on(timeline);
      on(help);
      on(share);
      on(adding);
      on(measures);
      on(visits);
      on(other);
      on(slices);
      on(leave);
      on(deleting);
      on(deleted);
      on(changed);
      on(unsaved);
      store.select(only("undone"), (state) => {
        const said = state.undone && el("span", {}, state.undone.says);
        undone.replaceChildren(...(said ? [said] : []));
        setTimeout(() => said?.remove(), UNDONE_MS);
      });
      store.select(only("step", "problems", "graphics", "announcement"), (state) => {
        page.set(state.problems.page);
        model.set(state.problems.model);
        distances.set(state.problems.distances);
        refit.set(state.step === "body" ? undefined : state.problems.fit);
        show(graphics, state.graphics !== "ok");
        setText(graphics, state.graphics === "absent" ? errors.noGraphics : state.graphics === "lost" ? errors.graphicsLost : "");
        setText(live, state.announcement);
      });
    },
  };
}

/** The bar on the stage; a table beside either of two stances can be shown. */
const shownInViewBar = (state: Session): ViewBarShown => {
  const shown = viewBarShown(state);
  const isBoth = isComparing(state);
  return {
    ...shown,
    looks: {
      ...shown.looks,
      ...(hasMirror(state) ? { mirror: state.showMirror } : {}),
      ...(isBoth && hasLoose(state.stances.other?.scan) ? { loose: state.showLoose } : {}),
      ...(isBoth ? { linked: state.stances.isLinked } : {}),
      ...(hasInside(state) ? { slices: areSlicesOpen(state) } : {}),
    },
  };
};

/** Nothing was made of the scan that reading its file again would lose. */
const isUntouched = (state: Session): boolean => state.scan?.file != null && pickCount(state) === 0 && state.drawn.lines.past.length === 0 && state.drawing === "";

/** Scans may be dropped anywhere. */
function acceptDrops(veil: HTMLElement, actions: Actions): void {
  const hasFile = (event: DragEvent): boolean => event.dataTransfer?.types.includes("Files") ?? false;
  addEventListener("dragover", (event) => hasFile(event) && event.preventDefault()); // else the browser opens the file
  addEventListener("dragenter", (event) => show(veil, hasFile(event)));
  veil.addEventListener("dragleave", () => show(veil, false));
  addEventListener("drop", (event) => {
    event.preventDefault();
    show(veil, false);
    const files = [...(event.dataTransfer?.files ?? [])];
    if (files.length > 0) void actions.bring.files(files);
  });
}
