// Three slices through a lesion as the report prints them, for who looks at a result: the skin, the chest wall as the model has it,
// the lesion, and pale how far it may reach.  All from what the service says of the lesion.
import { el, svg } from "../../ui/dom";
import { type LaidLesion } from "./lesions";
import { lesionView as words } from "./viewText";

const HALF_MM = 100; // seen to each side of its centre

/** One sentence where the result shows no skin to cut. */
export function slicePictures({ name, slices, radius_mm: radius, error_mm: error }: LaidLesion): HTMLElement {
  if (slices.length === 0) return el("p", { class: "muted small" }, words.noSlices);
  const path = (lines: readonly (readonly (readonly number[])[])[]): string => lines.map((points) => points.map(([x = 0, y = 0], i) => `${i === 0 ? "M" : "L"}${x.toFixed(1)} ${(-y).toFixed(1)}`).join("")).join("");
  const circle = (r: number, look: string): SVGElement => svg("circle", { cx: 0, cy: 0, r, class: look });
  return el(
    "div",
    { class: "lesion-slices" },
    ...slices.map(({ plane, outlines_mm: skin, wall_mm: wall }) =>
      el(
        "figure",
        {},
        svg(
          "svg",
          { viewBox: [-HALF_MM, -HALF_MM, 2 * HALF_MM, 2 * HALF_MM].join(" "), role: "img", "aria-label": words.slice(plane, name) },
          svg("path", { d: path(skin), class: "slice-of-skin" }),
          svg("path", { d: path(wall), class: "slice-of-wall" }),
          ...(error ? [circle(radius + error, "depth-band")] : []),
          circle(radius, "depth-ball"),
        ),
        el("figcaption", { class: "small" }, words.planes[plane], el("span", { class: "muted" }, ` ${words.sides[plane]}`)),
      ),
    ),
    el("p", { class: "muted small" }, words.slicesHint),
  );
}
