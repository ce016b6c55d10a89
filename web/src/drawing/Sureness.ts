// The one mark of a pane: how wide the band of its lines is, in fingers, with the millimetres small; the least sure line by name.
import { type Fingers, fingersMark, fingersOf, saidWide, wideOf } from "../fit/fingers";
import { type FitSlice, isUnusable } from "../fit/state";
import { linesOn, marginOf } from "../fit/verdict";
import { el, fill, show } from "../ui/dom";
import { widthsOf } from "./lines/widths";
import { type DrawingSlice, type Laid, layerKey, shownPatterns } from "./state";
import * as text from "./text";

const words = text.sureness;

type Shown = Pick<FitSlice & DrawingSlice, "fit" | "drawn">;
type Shape = Pick<Laid["shapes"][number], "name" | "points" | "error_mm" | "line_error_mm"> & { readonly label?: string; readonly kind?: string };

/** The line with the widest place; `mm` is null where nothing is known of one. */
function leastSure({ fit, drawn }: Shown): { readonly label: string; readonly mm: number | null } | null {
  const on = (layer: "reference" | "carried", shapes: readonly Shape[]): Shape[] => shapes.filter(({ name, kind }) => kind !== "note" && !drawn.hidden.has(layerKey(layer, name)));
  const shapes = [...on("reference", shownPatterns({ fit, drawn })?.shapes ?? []), ...on("carried", drawn.onScan?.carried.shapes ?? [])];
  const widest = shapes.map((shape) => {
    const widths = widthsOf(shape);
    return { label: (shape.label ?? "") === "" ? text.drawing.shapeName(shape.name) : shape.label!, mm: widths.some(Number.isNaN) ? null : Math.max(...widths) };
  });
  return widest.sort((a, b) => (b.mm ?? Infinity) - (a.mm ?? Infinity))[0] ?? null;
}

export function createSureness(): { readonly element: HTMLElement; update(state: Shown): void } {
  const element = el("div", { class: "sureness", "aria-live": "polite", hidden: true });
  return {
    element,
    update(state: Shown): void {
      const { fit } = state;
      const isDone = fit?.state === "done" && !isUnusable(state);
      show(element, isDone);
      if (!isDone) return;
      const lines = linesOn(state);
      const mm = lines?.mm ?? null;
      const count: Fingers = fingersOf(mm);
      const least = leastSure(state);
      const isNamed = least !== null && (fingersOf(least.mm) ?? 4) > (count ?? 3);
      const leastWords = least === null ? "" : words.least(least.label, saidWide(least.mm));
      fill(element, [count, mm, lines?.of, leastWords, isNamed], () => [
        fingersMark(count),
        el("span", {}, wideOf(mm)),
        count === null ? null : el("span", { class: "muted small" }, marginOf(mm!)),
        isNamed ? el("span", { class: "muted small" }, words.wider(least.label)) : null,
        el("span", { class: "visually-hidden" }, `${lines?.of ?? ""}. ${leastWords}`),
      ]);
      element.title = [words.hint, leastWords].filter((part) => part !== "").join(" ");
    },
  };
}
