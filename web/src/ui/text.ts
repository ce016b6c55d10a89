// Words that every room uses.  Each room has a text.ts of its own with all of its sentences, ready for translation: another
// language is another set of these files.  Names and definitions of landmarks, shapes and drawings come from the model,
// notes and reasons from the service.

export const name = "BreastRig";
export const notice = "Research use only. Not a medical device.";
export const noticeLong =
  "Research use only. Not a medical device; not for diagnosis, treatment or surgical decisions. " +
  "Measurements carry scanner and fitting error.";
export const dismiss = "Dismiss";
export const close = "Close";

export const numberField = {
  units: { mm: "mm", cm: "cm", deg: "°", h: "o'clock" } as Record<string, string>,
  unclear: (label: string, written: string) => `${label}: “${written}” can be read in two ways. Write it with one comma or point, for the decimals.`,
  none: (label: string, written: string, isHour: boolean) => `${label}: “${written}” is no number. Write ${isHour ? "an hour, for instance 10:30 or 10.5" : "one, for instance 4.5 or 4,5"}.`,
  needed: (label: string) => `${label} needs a number.`,
  outside: (label: string, min: number | null, max: number | null, unit: string) => `${label} must lie between ${min ?? "−∞"} and ${max ?? "∞"}${unit === "mm" || unit === "cm" ? ` ${unit}` : unit === "deg" ? "°" : unit === "h" ? " o'clock" : ""}.`,
};
