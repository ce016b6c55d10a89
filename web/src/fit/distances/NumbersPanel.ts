// The right side: numbers with their units.  During a fit and in the replay those of the iteration on the screen,
// afterwards those of the result, exactly as the service reports them.
import type { Iterated, Result } from "../../api/types";
import { plainLabel, sideOf } from "../../landmarks/picks";
import { landmarks as landmarkText } from "../../landmarks/text";
import { inSentence } from "../../languages/words";
import { stanceLabel } from "../../scan/text";
import type { PageSlice } from "../../store/page";
import { row } from "../../ui/controls";
import { el, fill, setText, show } from "../../ui/dom";
import { margin } from "../../ui/margins";
import type { Panel } from "../../ui/Panel";
import { formatMm, formatMmWhole, formatPercent, formatSeconds, formatSignedMm } from "../../ui/units";
import { SCALE_MM, SCANNER_MM, summarise } from "./distances";
import type { Outdated } from "../outdated";
import { type FitSlice, isAtRest, isUnusable, shownIteration } from "../state";
import { KNOWN_MM, linesOn, type WithLines } from "../verdict";
import { type Asks, createVerdictBox, type VerdictShown, type WaysOut } from "../VerdictBox";
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
  if (radius !== undefined && radius > KNOWN_MM) return [...distance, el("span", { class: "band", title: words.radiusUnknown }, words.unknown)];
  const band = radius === undefined ? [] : [margin(`\u2002${words.radius(formatMmWhole(radius))}`)];
  return [...distance, ...band, el("span", { class: "unit" }, " mm")];
}

function ofArms({ arm_angles_deg: angles = {} }: Result): Numbers {
  return Object.keys(angles).length === 0 ? [] : [[words.arms, words.armsOf(angles), "", words.armsHint]];
}

function ofResult(result: Result, state: Shown): HTMLElement[] {
  const surface = result.surface_distance_mm;
  const back = result.scan_to_model_mm;
  const points = result.landmark_distance_mm;
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
    ...(result.predicted ? [el("p", { class: "muted" }, words.predicted)] : []),
    ofPoints,
    block(words.surface, words.surfaceHint, [
      [words.mean, formatMm(surface.mean), "mm"],
      ...spread(surface),
      [words.coverage, formatPercent(surface.coverage), "%", words.coverageHint],
    ]),
    ...ofSigned,
    block(words.scanToModel, words.scanToModelHint, [[words.mean, formatMm(back.mean), "mm"], ...spread(back)]),
    ...ofModelAlone(result),
    block(words.run, "", [
      [words.solve, formatSeconds(result.timing_s.solve), "s"],
      [words.total, formatSeconds(result.timing_s.total), "s"],
      [words.iterations, String(result.iterations)],
      [words.stance, inSentence(stanceLabel(result.stance))],
      ...ofArms(result),
    ]),
    el("p", { class: "muted small stop" }, `${words.stop}: ${result.stop_reason}`),
  ];
}

/** Each landmark with its distance to the pick and its radius, folded. */
function ofEach(result: Result, state: Shown): HTMLElement[] {
  const points = result.landmark_distance_mm;
  const labels = new Map(state.meta?.landmarks.map((entry) => [entry.name, entry.label]));
  const radii = result.landmark_uncertainty_mm ?? {};
  const known = new Set([...Object.keys(points.each), ...Object.keys(radii)]);
  const named = [...new Set([...labels.keys(), ...known])].filter((name) => known.has(name)); // as they are listed
  if (named.length === 0) return [];
  const each = named.map((name) => {
    const side = landmarkText.sideShort[sideOf(name)];
    const chip = side === "" ? null : el("span", { class: `mini side-${sideOf(name)}`, title: landmarkText.sides[sideOf(name)] }, side);
    const label = el("dt", {}, plainLabel(labels.get(name) ?? name), chip);
    return el("div", { class: "row", "data-landmark": name }, label, el("dd", {}, ...ofLandmark(points.each[name], radii[name])));
  });
  return [el("details", { title: named.some((name) => name in radii) ? words.eachHint : words.landmarksHint }, el("summary", {}, words.each), el("dl", {}, ...each))];
}

/** What the rig reaches without the layer that follows the skin; nothing where there is no layer. */
function ofModelAlone({ refined, model_alone: alone }: Result): HTMLElement[] {
  if (!refined || !alone) return [];
  const { surface_distance_mm: surface, landmark_distance_mm: points } = alone;
  const landmarks: Numbers = points.mean === null ? [] : [[words.landmarkDistance, formatMm(points.mean), "mm"]];
  return [block(words.aloneBlock, words.aloneHint, [[words.mean, formatMm(surface.mean), "mm"], ...spread(surface), ...landmarks])];
}

type Shown = Pick<PageSlice & FitSlice, "meta" | "fit"> & Omit<VerdictShown, "result" | "failed">;

/** Where a fit can grow old and questions are asked: whether it has, what they are, and what a person can do. */
interface Ageing<More> extends WaysOut {
  readonly outdated: (state: PageSlice & FitSlice & More) => Outdated;
  readonly asks: (state: PageSlice & FitSlice & More) => Asks;
}

const NOTHING_ASKED: Asks = { isKnown: true, count: 0, points: 0, expected: null, outcome: "" };

/** What the fit is good for first; then, while it runs, how near it is; each landmark and all distances are folded away. */
export function createNumbersPanel<More extends Pick<WithLines, "drawn"> = Pick<WithLines, "drawn">>(ageing: Ageing<More> | null = null): Panel<Shown, PageSlice & FitSlice & More> {
  const number = el("span", { class: "hero-number" });
  const hero = el("p", { class: "hero" }, number, el("span", { class: "muted" }, words.meanDistance));
  const verdict = createVerdictBox(ageing);
  const now = el("div", { class: "numbers-body" });
  const each = el("div", {});
  const body = el("div", { class: "numbers-body" });
  const folded = el("details", { class: "solver" }, el("summary", {}, words.solver), body);
  const element = el("section", { class: "numbers", "aria-label": words.title }, ...verdict.elements, hero, now, each, folded);
  return {
    element,
    select: (state) => ({ meta: state.meta, fit: state.fit, old: ageing?.outdated(state) ?? null, lines: linesOn(state), asks: ageing?.asks(state) ?? NOTHING_ASKED }),
    update(state: Shown): void {
      const { fit } = state;
      const shown = shownIteration(fit);
      const result = fit && isAtRest(fit) ? fit.result : null;
      const isOfUse = result !== null && !isUnusable(state);
      show(hero, !result && shown !== null && fit?.state === "running");
      setText(number, shown && !result ? `${formatMm(shown.mean_distance_mm)}\u00a0mm` : "");
      element.classList.toggle("is-outdated", state.old !== null);
      verdict.update({ ...state, result: result ?? null, failed: fit?.state === "failed" ? fit.reason : null, old: fit?.state === "running" ? null : state.old });
      show(now, !result && !isUnusable(state));
      for (const part of [each, folded]) show(part, isOfUse);
      fill(each, [fit?.id, isOfUse], () => (isOfUse ? ofEach(result, state) : []));
      const key = [fit?.id, result ? "result" : shown?.iteration, fit?.distances != null];
      fill(body, key, () => (result ? ofResult(result, state) : []));
      fill(now, key, () => (!result && shown ? ofIteration(shown) : []));
    },
  };
}
