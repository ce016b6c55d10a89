// The bar above: whose work this is, the three tabs, undo, whether all is saved, and the menu that takes everything else.
import { planChanges } from "../../drawing/changes";
import { stepOf } from "../../drawing/state";
import { outdated } from "../../fit/outdated";
import { levelOf } from "../../fit/verdict";
import { isSizeLast, isSizeNext } from "../../landmarks/size/ruler";
import { size } from "../../landmarks/size/text";
import { changeLanguage, otherLanguages } from "../../languages/language";
import { picksSaid } from "../../landmarks/text";
import { dayName, isToday } from "../../stances/Strip";
import type { Step, Theme } from "../../store/page";
import { mayPlan } from "../../store/person";
import { only } from "../../store/store";
import { button, iconButton } from "../../ui/controls";
import { el, icon, setText, show } from "../../ui/dom";
import { createMenu, menuItem } from "../../ui/menu";
import type { Panel } from "../../ui/Panel";
import { name } from "../../ui/text";
import type { Actions } from "../actions";
import { isPlanned } from "../nextStep";
import type { Session } from "../session";
import { people } from "../people/text";
import * as text from "../text";

const words = text.top;
const TABS = ["body", "plan", "handover"] as const satisfies readonly Step[];

type Shown = Pick<Session, "meta" | "step" | "scan" | "picks" | "sizes" | "certain" | "saving" | "fit" | "stance" | "preset" | "refine" | "drawing" | "drawn" | "stances" | "theme" | "isSignedIn" | "fitsAtOnce">;

/** What undo would take back; null where nothing is there to be taken back. */
function undoable(state: Shown): string | null {
  const { meta, step, picks, drawing, drawn } = state;
  if (step === "body" || step === "points") {
    if (isSizeLast(state)) return size.change;
    const before = picks.past.at(-1);
    return before ? picksSaid(before, picks.present, meta?.landmarks ?? []) : null;
  }
  const before = drawn.lines.past.at(-1);
  return before ? planChanges(before, stepOf({ drawing, drawn }), [...(meta?.patterns ?? []), ...(meta?.drawings ?? [])]) : "";
}

/** "3 scans today", or the day of the newest. */
function scansSaid(created: readonly string[]): string {
  const newest = [...created].sort().at(-1);
  if (newest === undefined) return "";
  const day = new Date(newest);
  return words.scans(created.filter((at) => new Date(at).toDateString() === day.toDateString()).length, isToday(day, new Date()) ? null : dayName(day, new Date()));
}

export function createTopBar(actions: Actions): Panel<Shown> {
  const home = el("button", { type: "button", class: "logo", title: words.patients, "aria-label": words.patients, onclick: () => void actions.scan.leave() });
  const title = el("h1", {}, name);
  const about = el("span", { class: "scans-said muted" });
  const tabs = TABS.map((step) => {
    const tick = icon("check");
    const tab = el("button", { type: "button", class: "tab", id: `tab-${step}`, onclick: () => actions.page.goTo(step) }, tick, el("span", {}, text.page.steps[step]));
    return { step, tab, tick };
  });
  const nav = el("nav", { class: "tabs", "aria-label": text.page.stepsLabel }, ...tabs.map(({ tab }) => tab));
  const ofPlan = (): boolean => shown?.step === "plan" || shown?.step === "handover";
  const undo = button("", () => (ofPlan() ? actions.drawing.undo() : actions.body.undo()), "quiet undo", "undo");
  const redo = iconButton("redo", words.redo, () => (ofPlan() ? actions.drawing.redo() : actions.body.redo()));
  const saved = el("span", { class: "saved muted", role: "status" });
  const theme = menuItem("", "", () => actions.page.nextTheme());
  const fits = menuItem("", words.fitsAtOnceHint, () => actions.bring.chooseFitsAtOnce(!(shown?.fitsAtOnce ?? true)));
  const who = el("p", { class: "menu-who muted small" });
  const audit = menuItem(words.audit, words.auditHint, () => void window.open("/api/audit/page", "_blank", "noopener"));
  const leave = menuItem(words.signOut, "", () => void actions.signOut());
  const languages = otherLanguages().map(({ language, name: called }) => {
    const item = menuItem(called, "", () => changeLanguage(language));
    item.lang = language;
    return item;
  });
  const ofScan = [
    menuItem(words.picture, words.pictureHint, () => void actions.files.save()),
    menuItem(words.remove, "", () => actions.deletion.ask(true)),
  ];
  const menu = createMenu("page-menu", "\u2022\u2022\u2022", words.menu, "icon-only", ...ofScan, fits, theme, ...languages, menuItem(words.help, words.helpHint, () => actions.page.help(true)), audit, who, leave);
  const element = el("header", { class: "top-bar" }, home, title, about, nav, el("span", { class: "top-end" }, undo, redo, saved, menu.element));
  menu.card.addEventListener("click", ({ target }) => target !== menu.card && ![theme, fits].some((each) => each.contains(target as Node)) && menu.close());
  let shown: Shown | null = null;
  let drawn: Theme | null = null;
  return {
    element,
    select: only("meta", "step", "scan", "picks", "sizes", "certain", "saving", "fit", "stance", "preset", "refine", "drawing", "drawn", "stances", "theme", "isSignedIn", "fitsAtOnce"),
    update(state: Shown): void {
      shown = state;
      const { scan, step, stances } = state;
      setText(title, scan?.info.patient_code ?? name);
      title.title = scan ? words.code : "";
      setText(about, scan ? scansSaid(stances.scans.length > 0 ? stances.scans.map(({ created_at }) => created_at) : [scan.info.created_at]) : "");
      show(nav, scan !== null);
      const isSure = state.fit?.state === "done" && levelOf(state.fit.result) === "good" && outdated(state) === null;
      for (const { step: own, tab, tick } of tabs) {
        const isOpen = own === step || (own === "body" && step === "points");
        if (isOpen) tab.setAttribute("aria-current", "page");
        else tab.removeAttribute("aria-current");
        tick.style.display = (own === "body" && isSure) || (own === "plan" && isPlanned(state)) ? "" : "none";
      }
      const says = scan === null ? null : undoable(state);
      show(undo, says !== null);
      setText(undo.querySelector("span")!, says ? words.undo(says) : words.undoPlain);
      undo.title = says ? words.undo(says) : words.undoPlain;
      show(redo, scan !== null && (ofPlan() ? state.drawn.lines.future.length > 0 : isSizeNext(state) || state.picks.future.length > 0));
      const isBusy = [state.saving, state.drawn.saving];
      const unsaid = isBusy.find((each) => each === "unsaved") ?? isBusy.find((each) => each === "saving") ?? "saved";
      setText(saved, scan === null ? "" : words[unsaid]);
      show(ofScan[0]!, scan !== null);
      show(ofScan[1]!, scan !== null && mayPlan(state));
      show(leave, state.isSignedIn);
      const person = state.meta?.person ?? null;
      show(who, person !== null);
      show(audit, person === null || person.role === "administer");
      if (person) setText(who, `${people.who(person.name)} · ${people.roles[person.role]}`);
      setText(fits.querySelector("span")!, words.fitsAtOnce(state.fitsAtOnce));
      if (state.theme === drawn) return;
      drawn = state.theme;
      setText(theme.querySelector("span")!, words.theme(state.theme));
    },
  };
}
