// The few controls that the panels share.
import { el, icon, type IconName, setText, show } from "./dom";
import { dismiss } from "./text";

export interface Option<Value extends string> {
  value: Value;
  label: string;
  hint?: string;
}

export function button(label: string, pressed: () => void, look = "quiet", image?: IconName): HTMLButtonElement {
  return el("button", { type: "button", class: `button ${look}`, onclick: pressed }, image ? icon(image) : null, el("span", {}, label));
}

export function iconButton(image: IconName, label: string, pressed: () => void): HTMLButtonElement {
  return el("button", { type: "button", class: "button icon-only", "aria-label": label, title: label, onclick: pressed }, icon(image));
}

/** A labelled list of choices; `set` fills and selects without firing. */
export function select<Value extends string>(label: string, chosen: (value: Value) => void, look = "field") {
  const list = el("select", { onchange: () => chosen(list.value as Value) });
  const element = el("label", { class: look }, el("span", {}, label), list);
  let written = "";
  return {
    element,
    set(options: readonly Option<Value>[], value: Value): void {
      const key = JSON.stringify(options);
      if (key !== written) list.replaceChildren(...options.map((option) => el("option", { value: option.value }, option.label)));
      written = key;
      if (list.value !== value) list.value = value;
    },
    enable: (isOn: boolean): void => void (list.disabled = !isOn),
  };
}

/** A row of buttons of which one is chosen. */
export function segmented<Value extends string>(label: string, options: readonly Option<Value>[], chosen: (value: Value) => void) {
  const buttons = options.map((option) => {
    const hint = option.hint ?? option.label;
    return el("button", { type: "button", title: hint, "data-value": option.value, onclick: () => chosen(option.value) }, option.label);
  });
  return {
    element: el("div", { class: "segmented", role: "group", "aria-label": label }, ...buttons),
    set(value: Value | null): void {
      for (const each of buttons) each.setAttribute("aria-pressed", String(each.dataset.value === value));
    },
  };
}

/** For file buttons whose files may have no ending, as on a PACS's media: the chooser hides what is not listed. */
export const ANY_FILE = null;

/** A file button: the label is the button, so that it needs no script to open the chooser. */
export const fileButton = (label: string, accept: string | null, look: string, chosen: (file: File) => void): HTMLLabelElement => filesButton(label, accept, look, ([file]) => file && chosen(file), false);

/** The same for several at once. */
export function filesButton(label: string, accept: string | null, look: string, chosen: (files: readonly File[]) => void, multiple = true): HTMLLabelElement {
  const input = el("input", {
    type: "file",
    accept,
    multiple,
    class: "visually-hidden",
    onchange: () => {
      const files = [...(input.files ?? [])];
      input.value = ""; // the same file may be chosen again
      if (files.length > 0) chosen(files);
    },
  });
  return el("label", { class: `button ${look} file` }, input, icon("upload"), el("span", {}, label));
}

/** What went wrong here, and a way to put it aside. */
export function problem(dismissed: () => void) {
  const words = el("p", {});
  const element = el("div", { class: "problem", role: "alert", hidden: true }, icon("alert"), words, iconButton("close", dismiss, dismissed));
  return {
    element,
    set(message: string | undefined): void {
      setText(words, message ?? "");
      show(element, message !== undefined);
    },
  };
}

/** Name and value, the unit in a lighter weight. */
export function row(name: string, value: string, unit = "", hint = ""): HTMLElement {
  const amount = el("dd", {}, value, unit === "" ? null : el("span", { class: "unit" }, ` ${unit}`));
  return el("div", { class: "row", ...(hint ? { title: hint } : {}) }, el("dt", {}, name), amount);
}
