// Says wherever somebody is on the page that the service does not have what was typed or drawn, and that it is not lost.
import type { PageSlice } from "../../store/page";
import { only } from "../../store/store";
import { button } from "../../ui/controls";
import { el, setText, show } from "../../ui/dom";
import type { Panel } from "../../ui/Panel";
import { unsaved as words } from "../text";

export function createUnsavedBar(tryNow: () => void): Panel<Pick<PageSlice, "unsaved">> {
  const what = el("p", {});
  const bar = el("div", { class: "notice-bar unsaved-bar", hidden: true }, what, button(words.now, tryNow, "outlined"));
  const element = el("div", { role: "status", "aria-live": "polite" }, bar); // a region that is there before it speaks
  return {
    element,
    select: only("unsaved"),
    update({ unsaved }): void {
      show(bar, unsaved !== null);
      if (unsaved) setText(what, words.says(unsaved.what, unsaved.why, unsaved.isFull));
    },
  };
}
