// A lesion inside the body, given by its centre in the scan's frame, as a report of an image has it.
import type { PlanLesion } from "../../api/types";
import { button } from "../../ui/controls";
import { el, setText, show } from "../../ui/dom";
import { numberField } from "../../ui/NumberField";
import { lesionAt, RADIUS_MM, readCenter } from "../lesions/lesions";
import { lesions as words } from "../text";

/** `numbered`: what the next one is called where no name is given; `mark`: it is shown in the slices instead. */
export function createLesionForm(numbered: () => string, added: (lesion: PlanLesion) => void, mark: () => void) {
  let radiusMm: number = RADIUS_MM.usual;
  const name = el("input", { type: "text", maxlength: 100 });
  const center = el("input", { type: "text", maxlength: 100, placeholder: words.centerHint, "data-parameter": "center" });
  const radius = numberField({ name: "lesion_radius_mm", label: words.radius, unit: "mm", min: RADIUS_MM.least, max: RADIUS_MM.most, hint: "", mayBeEmpty: false, changed: (mm) => mm !== null && (radiusMm = mm) });
  radius.set(radiusMm);
  const wrong = el("p", { class: "look-here", role: "status", hidden: true });
  const add = button(words.add, () => {
    const place = readCenter(center.value);
    setText(wrong, place ? "" : words.noPlace);
    show(wrong, place === null);
    if (!place) return;
    added(lesionAt(name.value.trim() || numbered(), place, radiusMm));
    name.value = center.value = "";
  }, "quiet outlined");
  const inSlices = button(words.mark, mark, "outlined wide");
  const element = el("div", { class: "panel lesion-form" }, inSlices, el("label", { class: "field wide" }, el("span", {}, words.name), name), el("label", { class: "field wide" }, el("span", {}, words.center), center), radius.element, wrong, add);
  return { element, update: (hasImage: boolean): void => show(inSlices, hasImage) };
}
