// What is said of the lesion that is looked at: how deep it lies as a picture, its other distances with their bands, and a way
// to move it.  Loaded when one is chosen.
import { button } from "../../ui/controls";
import { el, svg } from "../../ui/dom";
import { withMargins } from "../../ui/margins";
import { type LaidLesion, saidDistances } from "./lesions";
import { depthPicture, HIGH, WIDE } from "./depth";
import { lesionView as words } from "./viewText";
import "./lesion_view.css";

/** `move`: takes it into the hand, or lays it down; null where it was given on another scan. */
export function lesionView(lesion: LaidLesion, line: string | null, move: { readonly isOn: boolean; readonly take: () => void } | null): HTMLElement {
  const facts = [...saidDistances(lesion, line).filter(({ kind }) => kind !== "skin").map((each): [string, string] => [words.to(each), words.banded(each)]), [words.place, words.placed(lesion)] as const];
  const take = move && button(words.move, move.take, "quiet outlined");
  take?.setAttribute("aria-pressed", String(move!.isOn));
  take?.setAttribute("aria-label", words.moveIt(lesion.name));
  return el(
    "div",
    { class: "lesion-view" },
    depthView(lesion),
    el("dl", {}, ...facts.map(([name, value]) => el("div", { class: "row" }, el("dt", {}, name), el("dd", {}, ...(name === words.place ? [value] : withMargins(value)))))),
    ...(lesion.seen ? [] : [el("p", { class: "look-here" }, words.unseen)]),
    take,
    el("p", { class: "muted small" }, move ? `${words.straight} ${words.moves}` : words.straight),
  );
}

/** From the skin to the right: the lesion with its band, and the chest wall as the model has it. */
function depthView(lesion: LaidLesion): SVGElement {
  const { skin, at, band, radius, wall, wallBand, words: x } = depthPicture(lesion);
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
    ...(wall === null ? [] : [svg("path", { d: `M${wall} 18V58`, class: "depth-wall" }), text(words.wall, WIDE, 12, "is-end")]),
    svg("path", { d: `M${skin} 18V58`, class: "depth-skin" }),
    text(words.skin, Math.max(0, skin - 2), 12, ""),
    ...(band ? [svg("rect", { x: band[0], y: 30, width: Math.max(band[1] - band[0], 1), height: 16, rx: 8, class: "depth-band" })] : []),
    svg("circle", { cx: at, cy: 38, r: radius, class: "depth-ball" }),
    text(said.mm, x, 74, "is-middle is-number"),
    text(said.band, x, 90, "is-middle is-muted"),
  );
}
