// Each ± in a sentence or a row: seen when it is pointed at or has the focus, heard always.  How sure lines are is the band on the body.
import { el } from "./dom";

const MARGIN = /((?:,\s*)?±\s?\d[\d.]*(?:\s?to\s?\d[\d.]*)?(?:\s?(?:mm|ml|°))?)/;

export const withMargins = (words: string): (string | HTMLElement)[] => words.split(MARGIN).filter((part) => part !== "").map((part) => (part.includes("±") ? margin(part) : part));

export const margin = (words: string): HTMLElement => el("span", { class: "pm" }, words);
