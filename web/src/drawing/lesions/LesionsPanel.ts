// What an image shows inside the body: each with its distances on this scan, and how far it may be off where it was carried.
import type { ScanSlice } from "../../scan/state";
import { only } from "../../store/store";
import { button } from "../../ui/controls";
import { el, setText, show } from "../../ui/dom";
import { numberField } from "../../ui/NumberField";
import type { Panel } from "../../ui/Panel";
import type { PlanLesion } from "../../api/types";
import type { DrawingSlice } from "../state";
import * as text from "../text";
import { createLesionList } from "./LesionList";
import { lesionAt, lesionsOnScan, readCenter } from "./lesions";

const words = text.lesions;
const RADIUS_MM = { least: 0.5, most: 80, usual: 5 }; // as the service takes it

type Shown = Pick<ScanSlice & DrawingSlice, "scan" | "drawn" | "lesion">;

export function createLesions(choose: (id: string | null) => void, change: (lesions: readonly PlanLesion[]) => void): Panel<Shown> {
  let own: readonly PlanLesion[] = [];
  let radiusMm: number = RADIUS_MM.usual;
  let hadAny = false;
  const name = el("input", { type: "text", maxlength: 100 });
  const center = el("input", { type: "text", maxlength: 100, placeholder: words.centerHint, "data-parameter": "center" });
  const radius = numberField({ name: "lesion_radius_mm", label: words.radius, unit: "mm", min: RADIUS_MM.least, max: RADIUS_MM.most, hint: "", mayBeEmpty: false, changed: (mm) => mm !== null && (radiusMm = mm) });
  const wrong = el("p", { class: "look-here", role: "status", hidden: true });
  const add = button(words.add, () => {
    const place = readCenter(center.value);
    setText(wrong, place ? "" : words.noPlace);
    show(wrong, place === null);
    if (!place) return;
    const added = lesionAt(name.value.trim() || words.numbered(own.length + 1), place, radiusMm);
    change([...own, added]);
    choose(added.id);
    name.value = center.value = "";
  }, "quiet outlined");
  const list = createLesionList(choose, change);
  const form = el("details", { class: "lesions" }, el("summary", {}, words.give), el("div", { class: "panel" }, el("label", { class: "field wide" }, el("span", {}, words.name), name), el("label", { class: "field wide" }, el("span", {}, words.center), center), radius.element, wrong, add));
  const element = el("details", { class: "lesions" }, el("summary", {}, words.title), el("div", { class: "panel" }, list.element, form));

  return {
    element,
    select: only("scan", "drawn", "lesion"),
    update({ drawn, lesion }: Shown): void {
      own = drawn.lesions;
      radius.set(radiusMm);
      const plan = drawn.onScan?.plan ?? null;
      const laid = lesionsOnScan(plan);
      const hasAny = own.length + laid.length > 0;
      if (hasAny && !hadAny) element.open = true;
      hadAny = hasAny;
      form.open ||= !hasAny;
      list.update({ laid, unit: plan?.unit ?? "mm", own, lesion, line: drawn.chosen });
    },
  };
}
