// Mean distance over the iterations, small: it shows whether the fit still moves and where the slider stands.
import { only } from "../../store/store";
import { el, setText, show, svg } from "../../ui/dom";
import type { Panel } from "../../ui/Panel";
import { formatMm } from "../../ui/units";
import type { FitSlice } from "../state";
import * as text from "../text";

const WIDTH = 232;
const HEIGHT = 68;
const EDGE = 5;

/** Points of the curve in the picture's units; the vertical axis starts at zero. */
export function curvePoints(values: readonly number[], slots: number): [number, number][] {
  const top = Math.max(...values, 1e-9);
  const last = Math.max(1, slots - 1);
  return values.map((value, i) => [
    EDGE + ((WIDTH - 2 * EDGE) * i) / last,
    HEIGHT - EDGE - ((HEIGHT - 2 * EDGE) * value) / top,
  ]);
}

type Shown = Pick<FitSlice, "fit">;

export function createDistanceCurve(): Panel<Shown> {
  const line = svg("polyline", { class: "curve-line", fill: "none" });
  const rest = svg("polyline", { class: "curve-rest", fill: "none" });
  const dot = svg("circle", { class: "curve-dot", r: 3.5 });
  const base = svg("line", { class: "curve-base", x1: EDGE, x2: WIDTH - EDGE, y1: HEIGHT - EDGE, y2: HEIGHT - EDGE });
  const picture = svg("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": text.numbers.curve }, base, rest, line, dot);
  const top = el("span", { class: "curve-top muted" });
  const element = el("figure", { class: "curve" }, top, el("figcaption", { class: "visually-hidden" }, text.numbers.curve));
  element.prepend(picture);
  return {
    element,
    select: only("fit"),
    update(state: Shown): void {
      const fit = state.fit;
      const values = fit?.iterations.map((each) => each.mean_distance_mm) ?? [];
      show(element, values.length > 1);
      if (values.length < 2 || !fit) return;
      const points = curvePoints(values, values.length);
      const write = (some: [number, number][]): string => some.map(([x, y]) => `${x.toFixed(1)},${y.toFixed(1)}`).join(" ");
      const at = Math.max(0, fit.shown);
      line.setAttribute("points", write(points.slice(0, at + 1)));
      rest.setAttribute("points", write(points.slice(at)));
      dot.setAttribute("cx", String(points[at]?.[0] ?? 0));
      dot.setAttribute("cy", String(points[at]?.[1] ?? 0));
      setText(top, `${formatMm(Math.max(...values))} mm`);
    },
  };
}
