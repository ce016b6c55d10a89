// What the colours of the mirrored breast mean, and how much both differ.
import { screenColourOf, SCALE_MM, SCANNER_MM } from "../../fit/distances/distances";
import type { FitSlice } from "../../fit/state";
import { el, setText, show } from "../../ui/dom";
import type { Panel } from "../../ui/Panel";
import { formatMm } from "../../ui/units";
import { mirrorPlane } from "./mirror";
import type { Asymmetry } from "./mirroredBreast";
import { mirrored as words } from "../text";

/** mm at the ends of the scale; breasts of one woman differ by more than a fit does. */
export const MIRROR_MM = 15;

type Shown = Pick<FitSlice, "fit" | "showMirror"> & { readonly asymmetry: Asymmetry | null };

/** There are two sides to compare. */
export const hasMirror = ({ fit }: Pick<FitSlice, "fit">): boolean => fit?.state === "done" && fit.result !== null && fit.surface !== null && mirrorPlane(fit.result) !== null;

export function createMirrorLegend(): Panel<Shown> {
  const scale = el("div", { class: "mirror-scale", "aria-hidden": "true" });
  const colour = (mm: number): string => `rgb(${screenColourOf(mm).join(" ")})`;
  scale.style.background = `linear-gradient(to right, ${[-SCALE_MM, -SCANNER_MM - 0.01, -SCANNER_MM, SCANNER_MM, SCANNER_MM + 0.01, SCALE_MM].map((mm) => `${colour(mm)} ${50 + 50 * placeOf(mm)}%`).join(", ")})`;
  const says = el("p", { class: "muted small" });
  const element = el("div", { class: "mirror-legend", role: "status", hidden: true }, el("p", {}, words.title), scale, el("div", { class: "mirror-ends small" }, el("span", {}, words.deeper(MIRROR_MM)), el("span", {}, words.farther(MIRROR_MM))), says);
  return {
    element,
    select: ({ fit, showMirror, asymmetry }) => ({ fit, showMirror, asymmetry }),
    update(state: Shown): void {
      show(element, state.showMirror && hasMirror(state));
      setText(says, state.asymmetry ? words.numbers(formatMm(state.asymmetry.medianMm), formatMm(state.asymmetry.mostMm)) : "");
    },
  };
}

/** -1 to 1 along the bar, of a place on the scale of distances. */
function placeOf(mm: number): number {
  const away = Math.abs(mm) <= SCANNER_MM ? Math.abs(mm) : SCANNER_MM + ((Math.abs(mm) - SCANNER_MM) / (SCALE_MM - SCANNER_MM)) * (MIRROR_MM - SCANNER_MM);
  return (Math.sign(mm) * away) / MIRROR_MM;
}
