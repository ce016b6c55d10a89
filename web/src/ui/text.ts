// Words that every room uses.  Each room has a text.ts of its own with all of its sentences, ready for translation: another
// language is another set of these files.  Names and definitions of landmarks, shapes and drawings come from the model,
// notes and reasons from the service.

import { word } from "../languages/words";

export const name = "BreastRig";
export const notice = word("ui.notice");
export const noticeLong =
  word("ui.noticeLong");
export const dismiss = word("ui.dismiss");
export const close = word("ui.close");
export const keys = { enter: word("ui.keys.enter"), escape: word("ui.keys.escape") };

export const numberField = {
  units: { mm: "mm", cm: "cm", deg: "°", h: word("ui.numberField.units.h") } as Record<string, string>,
  unclear: (label: string, written: string) => word("ui.numberField.unclear", { label, written }),
  none: (label: string, written: string, isHour: boolean) => word(isHour ? "ui.numberField.noHour" : "ui.numberField.none", { label, written }),
  needed: (label: string) => word("ui.numberField.needed", { label }),
  outside: (label: string, min: number | null, max: number | null, unit: string) => word(unit === "h" ? "ui.numberField.outsideHours" : "ui.numberField.outside", { label, min: min ?? "−∞", max: max ?? "∞", unit: unit === "mm" || unit === "cm" ? ` ${unit}` : unit === "deg" ? "°" : "" }),
};
