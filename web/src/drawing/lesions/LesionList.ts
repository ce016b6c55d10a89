// The lesions of a scan: each a button that shows it through the skin, with what is said of it below.
import { button, iconButton } from "../../ui/controls";
import { el, fill } from "../../ui/dom";
import type { PlanLesion, Unit } from "../../api/types";
import { mmFrom } from "../../ui/units";
import * as text from "../text";
import type { Hand } from "./LesionView";
import { type LaidLesion } from "./lesions";

const words = text.lesions;

interface Shown {
  readonly laid: readonly LaidLesion[]; // as the service has them on this scan, in its unit
  readonly unit: Unit;
  readonly own: readonly PlanLesion[]; // that were given here, as they are now
  readonly lesion: string | null; // id of the one that is looked at
  readonly line: string | null; // the chosen one
}

/** `change`: of the own ones; null for a visitor. */
export function createLesionList(choose: (id: string | null) => void, change: ((own: readonly PlanLesion[]) => void) | null) {
  const list = el("ul", { class: "layers", "data-layer": "lesions" });
  return {
    element: list,
    update({ laid, unit, own, lesion, line }: Shown): void {
      const names = new Map([...own, ...laid].map(({ id, name, radius_mm }) => [id, { name, radius_mm }]));
      const focused = list.contains(document.activeElement) ? document.activeElement!.getAttribute("aria-label") : null;
      fill(list, [laid, own, lesion, line], () =>
        [...names].map(([id, { name, radius_mm }]) => {
          const here = laid.find((each) => each.id === id);
          const mine = change === null ? undefined : own.find((each) => each.id === id);
          const shown = button(name, () => choose(lesion === id ? null : id), "link");
          shown.setAttribute("aria-pressed", String(lesion === id));
          const row = el("li", { "data-line": name }, shown, el("span", { class: "muted small" }, words.says(radius_mm, here?.depth_mm ?? null)), mine ? iconButton("eraser", words.remove(name), () => change!(own.filter((each) => each !== mine))) : null);
          if (lesion === id && here) void showIn(row, here, unit, line, mine ? { center: mine.center, moved: (center) => change!(own.map((each) => (each === mine ? { ...each, center } : each))) } : null, focused);
          return row;
        }),
      );
    },
  };
}

async function showIn(row: HTMLElement, here: LaidLesion, unit: Unit, line: string | null, hand: Hand | null, focused: string | null): Promise<void> {
  const { lesionView } = await import("./LesionView");
  row.append(lesionView({ ...here, center: here.center.map((value) => mmFrom(value, unit)) as Hand["center"] }, line, hand));
  if (focused) row.querySelector<HTMLElement>(`[aria-label="${CSS.escape(focused)}"]`)?.focus(); // the slice that the arrow keys move it in
}
