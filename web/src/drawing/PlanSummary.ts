// The plan on this scan with its line errors.
import { drawingLabels } from "../fit/requestedDrawing";
import type { FitSlice } from "../fit/state";
import { lineErrorOf, marginOf } from "../fit/verdict";
import type { PageSlice } from "../store/page";
import { only } from "../store/store";
import { el, fill, setText, show } from "../ui/dom";
import { withMargins } from "../ui/margins";
import type { Panel } from "../ui/Panel";
import { plannedLabel } from "./DrawingLayers";
import { type DrawingSlice, type Laid, laidPatterns } from "./state";
import * as text from "./text";

const words = text.summary;

type Shown = Pick<PageSlice & FitSlice & DrawingSlice, "meta" | "fit" | "drawing" | "drawn"> & { readonly stances: { readonly isCarrying: boolean } };
type Shape = Pick<Laid["shapes"][number], "name" | "line_error_mm"> & { readonly label?: string; readonly kind?: string; readonly mirrored?: boolean };

/** Lines of one item are in one row. */
export function planRows(state: Shown): readonly [name: string, value: string][] {
  const { drawn, fit } = state;
  const labels = drawingLabels(state);
  const own = drawn.lines.present.map(({ name, mirrored }): [string, string] => [name, mirrored ? words.mirrored : words.own]);
  const laid = (shapes: readonly Shape[], drawing: string, where: string): [string, string][] => {
    const itemOf = (shape: Shape): string => (["pattern", "tumour"].includes(shape.kind ?? "pattern") ? plannedLabel(shape.kind ?? "pattern", drawing, labels) : lineName(shape));
    return [...new Set(shapes.map(itemOf))].map((name) => {
      const mm = lineErrorOf(shapes.filter((shape) => itemOf(shape) === name));
      const mirrored = shapes.some((shape) => itemOf(shape) === name && shape.mirrored) ? [words.mirrored] : [];
      return [name, [...mirrored, mm === null ? "" : mm === 0 ? words.given : marginOf(mm), where].filter((part) => part !== "").join(", ")];
    });
  };
  const drawing = drawn.onScan ? state.drawing : (fit?.drawingName ?? "");
  const lesions = new Map([...drawn.lesions, ...(drawn.onScan?.plan.lesions ?? [])].map(({ id, name }) => [id, name]));
  const balls = [...lesions].map(([id, name]): [string, string] => {
    const here = drawn.onScan?.plan.lesions.find((each) => each.id === id);
    return [name, !here ? (state.stances.isCarrying || !drawn.onScan ? words.busy : "") : here.carried ? [here.error_mm === null ? "" : marginOf(here.error_mm), words.carried].filter((part) => part !== "").join(", ") : words.given];
  });
  return [...own, ...balls, ...laid(laidPatterns({ fit, drawn })?.shapes ?? [], drawing, ""), ...laid(drawn.onScan?.carried.shapes ?? [], "", words.carried)];
}

export function createPlanSummary(): Panel<Shown> {
  const list = el("dl", {});
  const none = el("p", { class: "muted" }, words.none);
  const element = el("section", { class: "plan-summary block", "aria-label": words.title, title: words.hint, hidden: true }, el("h3", {}, words.title), list, none);

  return {
    element,
    select: only("meta", "fit", "drawing", "drawn", "stances"),
    update(state: Shown): void {
      const shown = planRows(state);
      show(element, state.fit !== null);
      show(none, shown.length === 0);
      setText(none, state.stances.isCarrying ? words.carrying : words.none);
      fill(list, shown.flat(), () => shown.map(([name, value]) => el("div", { class: "row" }, el("dt", {}, name), el("dd", {}, ...withMargins(value)))));
    },
  };
}

/** Its label, else its name without the side that it ends with. */
const lineName = ({ name, label }: Shape): string => {
  const spoken = (label ?? "") === "" ? name.replace(/_[LR]$/, "").replaceAll("_", " ") : label!;
  return spoken.charAt(0).toUpperCase() + spoken.slice(1);
};
