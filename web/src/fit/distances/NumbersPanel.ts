// The right side: numbers with their units.  During a fit and in the replay those of the iteration on the screen,
// afterwards those of the result, exactly as the service reports them.
import type { Iterated, Result } from "../../api/types";
import { plainLabel, sideOf } from "../../landmarks/picks";
import { landmarks as landmarkText } from "../../landmarks/text";
import { scan as scanText } from "../../scan/text";
import type { PageSlice } from "../../store/page";
import { button, row } from "../../ui/controls";
import { el, fill, icon, setText, show } from "../../ui/dom";
import type { Panel } from "../../ui/Panel";
import { formatMm, formatPercent, formatSeconds, formatSignedMm } from "../../ui/units";
import { createDistanceCurve } from "./DistanceCurve";
import { SCALE_MM, SCANNER_MM, summarise } from "./distances";
import type { Outdated } from "../outdated";
import { type FitSlice, isAtRest, shownIteration } from "../state";
import * as text from "../text";

const words = text.numbers;
type Numbers = readonly (readonly [name: string, value: string, unit?: string, hint?: string])[];

function block(title: string, hint: string, numbers: Numbers): HTMLElement {
  const list = numbers.map(([name, value, unit, why]) => row(name, value, unit, why));
  return el("section", { class: "block", ...(hint ? { title: hint } : {}) }, el("h3", {}, title), el("dl", {}, ...list));
}

const spread = ({ std, p95, max }: Pick<Result["scan_to_model_mm"], "std" | "p95" | "max">): Numbers => [
  [words.std, formatMm(std), "mm"],
  [words.p95, formatMm(p95), "mm"],
  [words.max, formatMm(max), "mm"],
];

function ofIteration(shown: Iterated): HTMLElement[] {
  const landmarks: Numbers = shown.landmark_distance_mm === null ? [] : [[words.landmarkDistance, formatMm(shown.landmark_distance_mm), "mm"]];
  return [
    block(words.live, "", [
      ...landmarks,
      [words.coverage, formatPercent(shown.coverage), "%", words.coverageHint],
      [words.stage, shown.stage],
      [words.elapsed, formatSeconds(shown.elapsed_s), "s"],
    ]),
  ];
}

/** Distance to the pick, where there is one, and how far the truth may be from the model's place. */
function ofLandmark(mm: number | undefined, radius: number | undefined): HTMLElement[] {
  const distance = mm === undefined ? [] : [el("span", {}, formatMm(mm))];
  const band = radius === undefined ? [] : [el("span", { class: "band", title: words.radiusHint(formatMm(radius)) }, words.radius(formatMm(radius)))];
  return [...distance, ...band, el("span", { class: "unit" }, " mm")];
}

function ofResult(result: Result, state: Shown): HTMLElement[] {
  const surface = result.surface_distance_mm;
  const back = result.scan_to_model_mm;
  const points = result.landmark_distance_mm;
  const labels = new Map(state.meta?.landmarks.map((entry) => [entry.name, entry.label]));
  const radii = result.landmark_uncertainty_mm ?? {};
  const known = new Set([...Object.keys(points.each), ...Object.keys(radii)]);
  const named = [...new Set([...labels.keys(), ...known])].filter((name) => known.has(name)); // as they are listed
  const each = named.map((name) => {
    const side = landmarkText.sideShort[sideOf(name)];
    const chip = side === "" ? null : el("span", { class: `mini side-${sideOf(name)}`, title: landmarkText.sides[sideOf(name)] }, side);
    const label = el("dt", {}, plainLabel(labels.get(name) ?? name), chip);
    return el("div", { class: "row", "data-landmark": name }, label, el("dd", {}, ...ofLandmark(points.each[name], radii[name])));
  });
  const signed = state.fit?.distances ? summarise(state.fit.distances) : null;
  const ofSigned: HTMLElement[] = signed
    ? [
        block(text.distances.block, text.distances.blockHint, [
          [text.distances.signedMean, formatSignedMm(signed.meanMm), "mm"],
          [text.distances.within(SCANNER_MM), formatPercent(signed.within), "%"],
          [text.distances.beyond(SCALE_MM), formatPercent(signed.beyond), "%"],
        ]),
      ]
    : [];
  const ofPoints =
    points.mean !== null
      ? block(words.landmarks, words.landmarksHint, [[words.mean, formatMm(points.mean), "mm"], [words.max, formatMm(points.max), "mm"]])
      : el("section", { class: "block" }, el("h3", {}, words.landmarks), el("p", { class: "muted" }, words.noLandmarks));
  return [
    ofPoints,
    ...(each.length > 0 ? [el("details", { title: named.some((name) => name in radii) ? words.eachHint : words.landmarksHint }, el("summary", {}, words.each), el("dl", {}, ...each))] : []),
    block(words.surface, words.surfaceHint, [
      ...spread(surface),
      [words.coverage, formatPercent(surface.coverage), "%", words.coverageHint],
    ]),
    ...ofSigned,
    block(words.scanToModel, words.scanToModelHint, [[words.mean, formatMm(back.mean), "mm"], ...spread(back)]),
    ...ofModelAlone(result),
    el(
      "details",
      { class: "solver" },
      el("summary", {}, words.solver),
      block(words.run, "", [
        [words.solve, formatSeconds(result.timing_s.solve), "s"],
        [words.total, formatSeconds(result.timing_s.total), "s"],
        [words.iterations, String(result.iterations)],
        [words.stance, scanText.stances[result.stance].toLowerCase()],
      ]),
      el("p", { class: "muted small stop" }, `${words.stop}: ${result.stop_reason}`),
    ),
  ];
}

/** What the rig reaches without the layer that follows the skin; nothing where there is no layer. */
function ofModelAlone({ refined, model_alone: alone }: Result): HTMLElement[] {
  if (!refined || !alone) return [];
  const { surface_distance_mm: surface, landmark_distance_mm: points } = alone;
  const landmarks: Numbers = points.mean === null ? [] : [[words.landmarkDistance, formatMm(points.mean), "mm"]];
  return [block(words.aloneBlock, words.aloneHint, [[words.mean, formatMm(surface.mean), "mm"], ...spread(surface), ...landmarks])];
}

/** "3 to 8", or one number where all round to the same. */
function formatRange(radii: readonly number[]): string {
  const [least, most] = [Math.min(...radii), Math.max(...radii)].map((mm) => Math.round(mm));
  return least === most ? `${most}` : `${least} to ${most}`;
}

const verdictLines = ({ level, reasons }: NonNullable<Result["verdict"]>): HTMLElement[] => [
  el("p", { class: "verdict-level" }, icon(level === "good" ? "check" : "alert"), words.verdicts[level]),
  ...(reasons.length === 0 && level === "good" ? [words.noReasons] : reasons).map((reason) => el("p", { class: "muted" }, reason)),
];

type Shown = Pick<PageSlice & FitSlice, "meta" | "fit"> & { readonly old: Outdated };

/** Where a fit can grow old: whether it has, and how another one is asked for. */
interface Ageing<More> {
  readonly outdated: (state: PageSlice & FitSlice & More) => Outdated;
  readonly again: () => void;
}

/** Verdict and its reasons first, then how far off the landmarks may be, then distances; what the solver did is folded away. */
export function createNumbersPanel<More extends object = object>(ageing: Ageing<More> | null = null): Panel<Shown, PageSlice & FitSlice & More> {
  const mean = el("span", { class: "hero-number" });
  const of = el("span", { class: "muted" });
  const alone = el("p", { class: "muted alone", title: words.aloneHint, hidden: true });
  const hero = el("p", { class: "hero" }, mean, el("span", { class: "unit" }, " mm "), of);
  const sure = el("p", { class: "muted sure", title: words.eachHint, hidden: true });
  const verdict = el("div", { class: "verdict", role: "status", hidden: true });
  const oldWords = el("p", {});
  const old = el("div", { class: "look-here outdated", role: "status", hidden: true }, oldWords, ageing ? button(words.again, ageing.again, "outlined") : null);
  const curve = createDistanceCurve();
  const body = el("div", { class: "numbers-body" });
  const before = el("p", { class: "muted" }, words.before);
  const element = el("section", { class: "numbers", "aria-label": words.title }, el("h2", {}, words.title), before, old, verdict, sure, hero, alone, curve.element, body);
  return {
    element,
    select: (state) => ({ meta: state.meta, fit: state.fit, old: ageing?.outdated(state) ?? null }),
    update(state: Shown): void {
      const { fit } = state;
      const shown = shownIteration(fit);
      const result = fit && isAtRest(fit) ? fit.result : null;
      show(before, !shown && !result);
      show(hero, Boolean(shown ?? result));
      const distance = result ? result.surface_distance_mm.mean : shown?.mean_distance_mm;
      setText(mean, distance === undefined ? "" : formatMm(distance));
      const ofModel = result?.refined ? result.model_alone?.surface_distance_mm.mean : undefined;
      setText(of, result?.refined ? words.ofSkin : words.meanDistance);
      show(alone, ofModel !== undefined);
      setText(alone, ofModel === undefined ? "" : words.alone(formatMm(ofModel)));
      const judged = result?.verdict;
      show(old, state.old !== null && fit?.state !== "running");
      setText(oldWords, state.old ? words.outdated[state.old] : "");
      element.classList.toggle("is-outdated", state.old !== null);
      const radii = Object.values(result?.landmark_uncertainty_mm ?? {});
      show(sure, radii.length > 0);
      setText(sure, radii.length === 0 ? "" : words.sure(formatRange(radii)));
      show(verdict, judged != null);
      verdict.classList.toggle("look-here", judged?.level === "check");
      verdict.classList.toggle("is-wrong", judged?.level === "unusable");
      fill(verdict, [fit?.id, judged?.level, judged?.reasons.join()], () => (judged ? verdictLines(judged) : []));
      curve.update(state);
      fill(body, [fit?.id, result ? "result" : shown?.iteration, fit?.distances != null], () => (result ? ofResult(result, state) : shown ? ofIteration(shown) : []));
    },
  };
}
