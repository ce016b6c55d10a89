// What is said of the lesion that is looked at: its distances with their bands, and slices through it in three planes, in which
// a hand or the arrow keys move it.  Loaded when one is chosen.
import { el, svg } from "../../ui/dom";
import { withMargins } from "../../ui/margins";
import type { Vector } from "../../api/types";
import { type LaidLesion, saidDistances } from "./lesions";
import { alongSlice, type LesionSlice, movedInSlice } from "./slices";
import { lesionView as words } from "./viewText";

const HALF_MM = 70; // of a slice
const STEP_MM = { key: 1, withShift: 5 };
const KEYS: Readonly<Record<string, readonly [number, number]>> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

/** Where it is now, mm; and what moves it: null where it was given on another scan. */
export interface Hand {
  readonly center: Vector;
  moved(to: Vector): void;
}

export function lesionView(lesion: LaidLesion, line: string | null, hand: Hand | null): HTMLElement {
  const facts = [...saidDistances(lesion, line).map((each): [string, string] => [words.to(each), words.banded(each)]), [words.place, words.placed(lesion)] as const];
  return el(
    "div",
    { class: "lesion-view" },
    el("dl", {}, ...facts.map(([name, value]) => el("div", { class: "row" }, el("dt", {}, name), el("dd", {}, ...withMargins(value))))),
    ...(lesion.seen ? [] : [el("p", { class: "look-here" }, words.unseen)]),
    el("div", { class: "lesion-slices" }, ...lesion.slices.map((slice) => sliceView(lesion, slice, hand))),
    lesion.slices.length === 0 ? null : el("p", { class: "muted small" }, hand ? words.slicesMove : words.slices),
  );
}

const pathOf = (lines: LesionSlice["wall_mm"]): string => lines.map((points) => points.map(([x, y], k) => `${k === 0 ? "M" : "L"}${x} ${-y}`).join("")).join("");

/** A figure 140 mm across around where the plan has the lesion; the ball is where it is now. */
function sliceView(lesion: LaidLesion, slice: LesionSlice, hand: Hand | null): HTMLElement {
  const { radius_mm: radius, error_mm: error } = lesion;
  const ball = svg("g", {}, svg("circle", { r: radius + (error ?? 0), class: "reach" }), svg("circle", { r: radius, class: "ball" }));
  const picture = svg("svg", { viewBox: `${-HALF_MM} ${-HALF_MM} ${2 * HALF_MM} ${2 * HALF_MM}`, role: "img", "aria-label": words.slice(slice.plane) }, svg("path", { d: pathOf(slice.wall_mm), class: "wall" }), svg("path", { d: pathOf(slice.outlines_mm), class: "skin" }), ball);
  const figure = el("figure", {}, el("figcaption", { class: "small muted" }, slice.plane));
  figure.prepend(picture);
  if (!hand) return figure;
  let offset: readonly [number, number] = [0, 0];
  const put = (): void => ball.setAttribute("transform", `translate(${offset[0]} ${-offset[1]})`);
  const mmPerPixel = (): number => (2 * HALF_MM) / picture.getBoundingClientRect().width;
  picture.setAttribute("tabindex", "0");
  picture.classList.add("may-move");
  picture.addEventListener("keydown", (event) => {
    const way = KEYS[event.key];
    if (!way) return;
    event.preventDefault();
    event.stopPropagation();
    const step = event.shiftKey ? STEP_MM.withShift : STEP_MM.key;
    hand.moved(movedInSlice(hand.center, slice, [step * way[0], step * way[1]]));
  });
  picture.addEventListener("pointerdown", (event) => {
    picture.setPointerCapture(event.pointerId);
    const from = offset;
    const move = (now: PointerEvent): void => {
      offset = [from[0] + (now.clientX - event.clientX) * mmPerPixel(), from[1] - (now.clientY - event.clientY) * mmPerPixel()];
      put();
    };
    picture.addEventListener("pointermove", move);
    picture.addEventListener("pointerup", () => {
      picture.removeEventListener("pointermove", move);
      if (offset !== from) hand.moved(movedInSlice(hand.center, slice, [offset[0] - from[0], offset[1] - from[1]]));
    }, { once: true });
  });
  offset = alongSlice(lesion.center, hand.center, slice); // until the plan with the change has been laid
  put();
  return figure;
}
