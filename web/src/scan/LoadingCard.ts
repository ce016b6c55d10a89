// Over the stage while a scan is on its way: what goes on, and how far it is.
import { only } from "../store/store";
import { el, setText, show } from "../ui/dom";
import type { Panel } from "../ui/Panel";
import type { ScanSlice } from "./state";
import * as text from "./text";

export function createLoadingCard(): Panel<Pick<ScanSlice, "loading">> {
  const bar = el("progress", { max: 1 });
  const phase = el("p", {});
  const element = el("div", { class: "loading", role: "status", hidden: true }, el("div", { class: "loading-card" }, phase, bar));
  return {
    element,
    select: only("loading"),
    update({ loading }): void {
      show(element, loading !== null);
      if (!loading) return;
      setText(phase, text.loading[loading.phase](loading.title));
      if (loading.phase === "sending") bar.value = loading.share;
      else bar.removeAttribute("value"); // runs to and fro
    },
  };
}
