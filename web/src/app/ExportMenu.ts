// Everything to take away, one click below the top bar.  A popover: the browser closes it and keeps it above all else.
import type { Actions } from "./actions";
import { el, icon, show } from "../ui/dom";
import type { Session } from "./session";
import { text } from "../ui/text";
import type { Panel } from "../ui/Panel";

const words = text.picture;

export function createExportMenu(actions: Actions): Panel {
  const open = el("button", { type: "button", class: "button quiet outlined", popovertarget: "export-menu", "aria-haspopup": "true" }, icon("download"), el("span", {}, words.menu));
  const close = (): void => menu.hidePopover();
  const item = (name: string, hint: string): HTMLElement[] => [el("span", {}, name), el("span", { class: "muted small" }, hint)];
  const picture = el("button", { type: "button", class: "menu-item", onclick: () => (close(), void actions.picture.save()) }, ...item(words.save, words.saveHint));
  const table = el("button", { type: "button", class: "menu-item", onclick: () => (close(), actions.picture.saveDistances()) }, ...item(words.distances, words.distancesHint));
  const links = text.result.downloads.map(({ key, name, what }) => ({ key, element: el("a", { class: "menu-item", download: name, onclick: close }, ...item(name, what)) }));
  const menu = el("div", { class: "menu", id: "export-menu", popover: "auto", "aria-label": words.menu, role: "group" }, picture, ...links.map(({ element }) => element), table);
  const element = el("div", { class: "export" }, open, menu);
  return {
    element,
    update({ scan, fit }: Session): void {
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
