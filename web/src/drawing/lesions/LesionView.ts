// What is said of the lesion that is looked at: how deep it lies as a picture, its other distances with their bands, where it
// lies as radiology writes it, beside what was typed of a report, and a way to move it.  Loaded when one is chosen.
import type { PlanLesion } from "../../api/types";
import { button } from "../../ui/controls";
import { el, svg } from "../../ui/dom";
import { withMargins } from "../../ui/margins";
import { type LaidLesion, saidDistances } from "./lesions";
import { depthPicture, HIGH, WIDE } from "./depth";
import { lesionView as words } from "./viewText";
import "./lesion_view.css";

/** Of a lesion that was given on the scan in work. */
export interface OwnLesion {
  readonly lesion: PlanLesion;
  readonly isMoved: boolean; // it is in the hand
  readonly move: () => void; // takes it into the hand, or lays it down
  readonly change: (part: Partial<PlanLesion>) => void;
}

/** `laid`: as the service has it on this scan; null before there is a model. */
export function lesionView(laid: LaidLesion | null, line: string | null, own: OwnLesion | null): HTMLElement {
  const distances = laid ? saidDistances(laid, line).filter(({ kind }) => kind !== "skin").map((each): [string, string] => [words.to(each), words.banded(each)]) : [];
  const facts: [string, string][] = laid ? [...distances, [words.place, words.placed(laid)], ...(laid.clock ? [[words.clock, words.byClock(laid.clock.text)] as [string, string]] : [])] : [];
  const plain = [words.place, words.clock];
  const take = own && button(words.moveIt(own.lesion.name), own.move, "quiet outlined");
  take?.setAttribute("aria-pressed", String(own!.isMoved));
  take?.setAttribute("aria-label", words.moveIt(own!.lesion.name)); // by which it is found again
  const field = (label: string, hint: string, value: string, changed: (value: string) => void): HTMLElement => {
    const input = el("input", { type: "text", maxlength: 100, placeholder: hint, "aria-label": label, onchange: () => changed(input.value.trim()) });
    input.value = value;
    return el("label", { class: "field wide" }, el("span", {}, label), input);
  };
  const check = laid?.radiology ?? null;
  return el(
    "div",
    { class: "lesion-view" },
    laid && depthView(laid),
    el("dl", {}, ...facts.map(([name, value]) => el("div", { class: "row" }, el("dt", {}, name), el("dd", {}, ...(plain.includes(name) ? [value] : withMargins(value)))))),
    ...(laid?.seen === false ? [el("p", { class: "look-here" }, words.unseen)] : []),
    own && field(words.name, "", own.lesion.name, (name) => name !== "" && own.change({ name })),
    own && field(words.radiology, words.radiologyHint, own.lesion.radiology ?? "", (radiology) => own.change({ radiology })),
    check && el("p", { class: check.agrees === false ? "lesion-contradicted" : "muted small", role: "status" }, check.text),
    take,
    laid && el("p", { class: "muted small" }, own ? `${words.straight} ${words.moves}` : words.straight),
  );
}

/** From the skin to the right: the lesion with its band, and the chest wall, seen or as the model has it. */
function depthView(lesion: LaidLesion): SVGElement {
  const { skin, at, band, radius, wall, wallBand, isWallSeen, words: x } = depthPicture(lesion);
  const depth = lesion.distances.find(({ kind }) => kind === "skin")!;
  const said = words.depth(lesion.depth_mm, depth);
  const text = (words: string, place: number, y: number, look: string): SVGElement => {
    const made = svg("text", { x: place, y, class: look });
    made.textContent = words;
    return made;
  };
  return svg(
    "svg",
    { viewBox: `0 0 ${WIDE} ${HIGH}`, class: "depth-ruler", role: "img", "aria-label": said.whole },
    svg("path", { d: `M${skin} 38H${WIDE}`, class: "depth-way" }),
    ...(wallBand ? [svg("rect", { x: wallBand[0], y: 22, width: wallBand[1] - wallBand[0], height: 32, class: "depth-wall-band" })] : []),
    ...(wall === null ? [] : [svg("path", { d: `M${wall} 18V58`, class: `depth-wall${isWallSeen ? " is-seen" : ""}` }), text(words.wall(isWallSeen), WIDE, 12, "is-end")]),
    svg("path", { d: `M${skin} 18V58`, class: "depth-skin" }),
    text(words.skin, Math.max(0, skin - 2), 12, ""),
    ...(band ? [svg("rect", { x: band[0], y: 30, width: Math.max(band[1] - band[0], 1), height: 16, rx: 8, class: "depth-band" })] : []),
    svg("circle", { cx: at, cy: 38, r: radius, class: "depth-ball" }),
    text(said.mm, x, 74, "is-middle is-number"),
    text(said.band, x, 90, "is-middle is-muted"),
  );
}
