// What an image shows inside the body: each with its depth on this scan, and how far it may be off where it was carried.
import type { FitSlice } from "../../fit/state";
import type { PageSlice } from "../../store/page";
import { only } from "../../store/store";
import { button, iconButton } from "../../ui/controls";
import { el, fill, setText, show } from "../../ui/dom";
import { numberField } from "../../ui/NumberField";
import type { Panel } from "../../ui/Panel";
import type { PlanLesion } from "../../api/types";
import type { DrawingSlice } from "../state";
import * as text from "../text";
import { lesionAt, lesionsOnScan, readCenter } from "./lesions";

const words = text.lesions;
const RADIUS_MM = { least: 0.5, most: 80, usual: 5 }; // as the service takes it

type Shown = Pick<PageSlice & FitSlice & DrawingSlice, "drawn">;

export function createLesions(change: (lesions: readonly PlanLesion[]) => void): Panel<Shown> {
  let own: readonly PlanLesion[] = [];
  let radiusMm: number = RADIUS_MM.usual;
  const name = el("input", { type: "text", maxlength: 100 });
  const center = el("input", { type: "text", maxlength: 100, placeholder: words.centerHint, "data-parameter": "center" });
  const radius = numberField({ name: "lesion_radius_mm", label: words.radius, unit: "mm", min: RADIUS_MM.least, max: RADIUS_MM.most, hint: "", mayBeEmpty: false, changed: (mm) => mm !== null && (radiusMm = mm) });
  const wrong = el("p", { class: "look-here", role: "status", hidden: true });
  const list = el("ul", { class: "layers", "data-layer": "lesions" });
  const add = button(words.add, () => {
    const place = readCenter(center.value);
    setText(wrong, place ? "" : words.noPlace);
    show(wrong, place === null);
    if (!place) return;
    change([...own, lesionAt(name.value.trim() || words.numbered(own.length + 1), place, radiusMm)]);
    name.value = center.value = "";
  }, "quiet outlined");
  const form = [el("label", { class: "field wide" }, el("span", {}, words.name), name), el("label", { class: "field wide" }, el("span", {}, words.center), center), radius.element, wrong, add];
  const element = el("details", { class: "lesions" }, el("summary", {}, words.title), el("div", { class: "panel" }, list, ...form));

  return {
    element,
    select: only("drawn"),
    update({ drawn }: Shown): void {
      own = drawn.lesions;
      radius.set(radiusMm);
      const laid = lesionsOnScan(drawn.onScan?.plan ?? null);
      const carried = laid.filter((each) => each.carried);
      fill(list, [own, laid], () => [
        ...own.map((each) => row(each.name, words.says(each.radius_mm, laid.find(({ id }) => id === each.id)?.depth_mm ?? null), iconButton("eraser", words.remove(each.name), () => change(own.filter((other) => other !== each))))),
        ...carried.map((each) => row(each.name, words.carried(words.says(each.radius_mm, each.depth_mm), each.error_mm), null)),
      ]);
    },
  };
}

const row = (name: string, says: string, more: HTMLElement | null): HTMLElement => el("li", { "data-line": name }, el("span", {}, name), el("span", { class: "muted small" }, says), more);
