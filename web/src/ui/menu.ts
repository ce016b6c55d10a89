// A button that opens a card beside it.  A popover: the browser closes it and keeps it above all else.
import { el, setText } from "./dom";

const GAP = 6; // pixels between button and card
const WIDE = 288; // as wide as ui/menu.css makes it

/** `look`: classes of the button; its words are `label` until `set` gives others. */
export function createMenu(id: string, label: string, hint: string, look: string, ...children: HTMLElement[]) {
  const words = el("span", {}, label);
  const open = el("button", { type: "button", class: `button ${look}`, popovertarget: id, "aria-haspopup": "true", title: hint, "aria-label": look.includes("icon-only") ? hint : null }, words);
  const card = el("div", { class: "menu", id, popover: "auto", role: "group", "aria-label": hint, onbeforetoggle: (event) => event.newState === "open" && place() }, ...children);

  /** Below the button, or above one at the window's foot. */
  function place(): void {
    const { left, right, top, bottom } = open.getBoundingClientRect();
    const isBelow = top < innerHeight / 2;
    card.style.top = isBelow ? `${bottom + GAP}px` : "auto";
    card.style.bottom = isBelow ? "auto" : `${innerHeight - top + GAP}px`;
    card.style.left = `${Math.max(GAP, Math.min(left + WIDE > innerWidth ? right - WIDE : left, innerWidth - WIDE - GAP))}px`;
    card.style.maxHeight = `${(isBelow ? innerHeight - bottom : top) - 2 * GAP}px`;
  }

  return { element: el("div", { class: "menu-of" }, open, card), open, card, close: (): void => card.hidePopover(), set: (now: string): void => setText(words, now) };
}

/** One line of a menu, with what it does below its name. */
export const menuItem = (name: string, hint: string, act: () => void): HTMLButtonElement =>
  el("button", { type: "button", class: "menu-item", onclick: act }, el("span", {}, name), hint === "" ? null : el("span", { class: "muted small" }, hint));
