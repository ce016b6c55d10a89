// Everything to take away, one click below the top bar.  A popover: the browser closes it and keeps it above all else.
import type { FitSlice } from "../fit/state";
import { result as resultText } from "../fit/text";
import type { ScanSlice } from "../scan/state";
import { only } from "../store/store";
import { el, icon, show } from "../ui/dom";
import type { Panel } from "../ui/Panel";
import type { ExportActions } from "./exportActions";
import * as text from "./text";

const words = text.files;

type Shown = Pick<ScanSlice & FitSlice, "scan" | "fit">;

export function createExportMenu(files: ExportActions): Panel<Shown> {
  const open = el("button", { type: "button", class: "button quiet outlined", popovertarget: "export-menu", "aria-haspopup": "true" }, icon("download"), el("span", {}, words.menu));
  const chosen = (save: () => void): void => {
    menu.hidePopover();
    save();
  };
  const item = (name: string, hint: string): HTMLElement[] => [el("span", {}, name), el("span", { class: "muted small" }, hint)];
  const picture = el("button", { type: "button", class: "menu-item", onclick: () => chosen(() => void files.save()) }, ...item(words.save, words.saveHint));
  const table = el("button", { type: "button", class: "menu-item", onclick: () => chosen(files.saveDistances) }, ...item(words.distances, words.distancesHint));
  const links = resultText.downloads.map(({ key, name, what }) => ({ key, element: el("a", { class: "menu-item", download: name, onclick: () => menu.hidePopover() }, ...item(name, what)) }));
  const menu = el("div", { class: "menu", id: "export-menu", popover: "auto", "aria-label": words.menu, role: "group" }, picture, ...links.map(({ element }) => element), table);
  const element = el("div", { class: "export" }, open, menu);
  return {
    element,
    select: only("scan", "fit"),
    update({ scan, fit }: Shown): void {
      show(element, scan !== null);
      const isDone = fit?.state === "done";
      for (const { key, element: link } of links) {
        show(link, isDone);
        if (fit && isDone) link.href = fit.links[key];
      }
      show(table, isDone && fit.distances !== null);
    },
  };
}
