// Name, what is open, light or dark, help.
import type { Theme } from "../store/page";
import { only } from "../store/store";
import { button, iconButton } from "../ui/controls";
import { el, icon, setText, show } from "../ui/dom";
import type { Panel } from "../ui/Panel";
import { name } from "../ui/text";
import type { Actions } from "./actions";
import { createExportMenu } from "./ExportMenu";
import type { Session } from "./session";
import * as text from "./text";

type Shown = Pick<Session, "scan" | "fit" | "theme" | "isSignedIn">;

/** `between`: stands after the title. */
export function createTopBar(actions: Actions, between: HTMLElement): Panel<Shown> {
  const code = el("strong", { class: "patient-code-shown", title: text.top.code });
  const title = el("span", { class: "scan-title" });
  const fresh = button(text.top.newScan, () => void actions.scan.leave());
  const share = button(text.top.share, () => void actions.share.open(), "quiet outlined", "link");
  const files = createExportMenu(actions.files);
  const leave = button(text.top.signOut, () => void actions.signOut());
  const theme = iconButton("system", text.top.theme("system"), () => actions.page.nextTheme());
  const help = el(
    "button",
    { type: "button", class: "button icon-only", "aria-label": text.top.help, title: text.top.help, onclick: () => actions.page.help(true) },
    el("span", { "aria-hidden": "true" }, "?"),
  );
  const mark = el("span", { class: "logo", "aria-hidden": "true" });
  const element = el("header", { class: "top-bar" }, mark, el("h1", {}, name), code, title, between, el("span", { class: "spring" }), share, files.element, fresh, theme, help, leave);
  let drawn: Theme | null = null;
  return {
    element,
    select: only("scan", "fit", "theme", "isSignedIn"),
    update(state: Shown): void {
      setText(code, state.scan?.info.patient_code ?? "");
      show(code, state.scan !== null);
      setText(title, state.scan?.title ?? "");
      show(share, state.fit?.state === "done");
      files.update(state);
      show(leave, state.isSignedIn);
      show(fresh, state.scan !== null);
      if (state.theme === drawn) return;
      drawn = state.theme;
      theme.replaceChildren(icon(state.theme === "system" ? "system" : state.theme === "dark" ? "moon" : "sun"));
      theme.title = text.top.theme(state.theme);
      theme.setAttribute("aria-label", theme.title);
    },
  };
}
