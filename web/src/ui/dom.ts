// Makes DOM elements in one expression.  Styles come from classes only: the page's policy forbids style attributes.

type Child = Node | string | null;
type Listeners = { [K in keyof HTMLElementEventMap as `on${K}`]?: (event: HTMLElementEventMap[K]) => void };
type Attributes = Listeners & Record<string, unknown>;

/** Attributes: `on…` adds a listener, true and false set and leave out, words and numbers are written as they are, null and undefined are left out. */
export function el<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  attributes: Attributes = {},
  ...children: Child[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === "function") element.addEventListener(name.slice(2), value as EventListener);
    else if (value === true) element.setAttribute(name, "");
    else if (typeof value === "string" || typeof value === "number") element.setAttribute(name, String(value));
  }
  element.append(...children.filter((child) => child !== null));
  return element;
}

/** Writes text only where it differs: screen readers and the layout stay quiet otherwise. */
export function setText(element: Element, words: string): void {
  if (element.textContent !== words) element.textContent = words;
}

export function show(element: HTMLElement, isShown: boolean): void {
  if (element.hidden === isShown) element.hidden = !isShown;
}

/** The field into which something was typed that nobody has heard of yet. */
let typed: Element | null = null;
const afterwards = new Map<Element, () => void>(); // what to fill as soon as that is said

/**
 * Replaces the children when `key` differs from the last one given for this element; while somebody types into one of them,
 * afterwards, and then calls `late`.  False where they are to be replaced.
 */
export function fill(element: HTMLElement, key: unknown, make: () => Child[], late?: () => void): boolean {
  afterwards.delete(element);
  const written = JSON.stringify(key);
  if (element.dataset.key === written) return true;
  if (typed && typed === document.activeElement && element.contains(typed)) {
    afterwards.set(element, () => {
      fill(element, key, make);
      late?.();
    });
    return false;
  }
  element.dataset.key = written;
  element.replaceChildren(...make().filter((child) => child !== null));
  return true;
}

function typingEnds(): void {
  typed = null;
  for (const each of [...afterwards.values()]) each();
}

/** Once a page, so that nothing is lost of what is typed. */
export function watchTyping(): void {
  document.addEventListener("input", ({ target }) => (typed = target instanceof Element && target.matches("input:not([type=checkbox], [type=radio], [type=range], [type=file]), textarea") ? target : null), true);
  document.addEventListener("change", ({ target }) => {
    if (!(target instanceof Element && target.matches("[type=date]"))) typed = null; // before who listens to the field: what it says is shown at once
  }, true);
  document.addEventListener("change", () => typed ?? typingEnds()); // a day is changed by each digit of its year
  document.addEventListener("focusout", typingEnds);
}

const SVG = "http://www.w3.org/2000/svg";

export function svg(tag: string, attributes: Record<string, string | number>, ...children: SVGElement[]): SVGElement {
  const element = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, String(value));
  element.append(...children);
  return element;
}

const ICONS = {
  undo: "M8 5 4 9l4 4M4 9h9a5 5 0 0 1 0 10h-3",
  redo: "m16 5 4 4-4 4M20 9h-9a5 5 0 0 0 0 10h3",
  close: "m6 6 12 12M18 6 6 18",
  back: "m14.5 6-6 6 6 6",
  on: "m9.5 6 6 6-6 6",
  check: "m5 12.5 4.5 4.5L19 7.5",
  play: "M8 5.5v13l10.5-6.5z",
  pause: "M8 5.5v13M16 5.5v13",
  upload: "M12 16V5m0 0L7.5 9.5M12 5l4.5 4.5M4.5 15v3a1.5 1.5 0 0 0 1.5 1.5h12a1.5 1.5 0 0 0 1.5-1.5v-3",
  download: "M12 5v11m0 0-4.5-4.5M12 16l4.5-4.5M4.5 15v3a1.5 1.5 0 0 0 1.5 1.5h12a1.5 1.5 0 0 0 1.5-1.5v-3",
  system: "M4 5.5h16v10.5H4zM9 19.5h6",
  link: "M10 14a4 4 0 0 0 6 .4l3-3a4 4 0 0 0-5.7-5.7l-1 1M14 10a4 4 0 0 0-6-.4l-3 3a4 4 0 0 0 5.7 5.7l1-1",
  exchange: "M4 9h15m-4-4 4 4-4 4M20 16H5m4-4-4 4 4 4",
  mirror: "M12 4v16M9 7 4 17h5zM15 7l5 10h-5z",
  table: "M3 13h18M6 13v6M18 13v6M8 9l2-4 2 4zM15.5 6.5h3v2.5h-3z",
  turn: "M20 12a8 8 0 1 1-2.6-5.9M20.5 3.5v4.7h-4.7",
  pen: "m4 20 1-4.5L16.2 4.3l3.5 3.5L8.5 19zM14 6.5 17.5 10",
  points: "M5 16.5a2 2 0 1 0 0 .1M12 7a2 2 0 1 0 0 .1M19 16.5a2 2 0 1 0 0 .1M6 15l5-6M13 9l5 6",
  eraser: "m9.5 19-5.3-5.3L14 4l6 6-9 9zM9.5 19H20M8.7 9.3l6 6",
  tape: "M3 16 16 3l5 5L8 21zM6.5 12.5l2 2M9.5 9.5l2.5 2.5M12.5 6.5l2 2",
  lasso: "M12 15c-5 0-9-2.2-9-5.2S7 4.5 12 4.5s9 2.3 9 5.3S17 15 12 15zM7.5 14.5c-1.5 1-1.8 3 0 4 1.3.7 1 2 .2 2.8",
  relief: "M2.5 17c5 0 4-9 7-9s2.5 6 4.5 6 1.5-4 3.5-4 2 7 4 7",
  finger: "M9 12.5V5a1.7 1.7 0 0 1 3.4 0v6l5 1.2a2 2 0 0 1 1.5 2.3l-.8 4.2a2.8 2.8 0 0 1-2.7 2.3h-3.6c-.8 0-1.6-.4-2.1-1l-4-5.2c-.8-1.2.6-2.6 1.8-1.8z",
  expand: "M4 9V4h5M20 9V4h-5M4 15v5h5M20 15v5h-5",
  alert: "M12 4 3 19.5h18zM12 10v4m0 2.6v.4",
} as const;

export type IconName = keyof typeof ICONS;

export const icon = (name: IconName): SVGElement =>
  svg("svg", { viewBox: "0 0 24 24", class: `icon icon-${name}`, "aria-hidden": "true" }, svg("path", { d: ICONS[name] }));

/** Offers text as a file for saving. */
export const saveFile = (name: string, content: string, type: string): void => saveBlob(name, new Blob([content], { type }));

export function saveBlob(name: string, blob: Blob): void {
  const url = URL.createObjectURL(blob);
  el("a", { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 1000);
}
