// The read-only page behind a share link: the body with its drawing, the numbers, the files; a passcode first where there is one.
import { changeLanguage, otherLanguages } from "../../languages/language";
import { locale } from "../../languages/words";
import "../../style.css";
import * as text from "../text";
import { ApiError } from "../../api/client";
import type { SharedResult } from "../../api/types";
import { createColourBar } from "../../fit/distances/ColourBar";
import { createNumbersPanel } from "../../fit/distances/NumbersPanel";
import { viewBarShown, withDistances } from "../../fit/state";
import { errors as fitErrors, result as resultText } from "../../fit/text";
import { createStore, only } from "../../store/store";
import { button } from "../../ui/controls";
import { el, fill, icon, setText, show } from "../../ui/dom";
import { follow } from "../../ui/Panel";
import { name, noticeLong } from "../../ui/text";
import { viewActions } from "../../viewer/actions";
import { errors as viewErrors, view as viewText } from "../../viewer/text";
import { createViewBar } from "../../viewer/ViewBar";
import { createLesionList } from "../../drawing/lesions/LesionList";
import { createSureness } from "../../drawing/Sureness";
import { lesionsOnScan } from "../../drawing/lesions/lesions";
import { lesions as lesionText } from "../../drawing/text";
import { openSharedViewer } from "./openViewer";
import { planList } from "./PlanList";
import { keepSecret, passSecretOn, takeSecret } from "./secret";
import { initialVisitor, type VisitorState } from "./state";
import { closeLink, openLink, readShared, visitOf } from "./visit";

const visit = visitOf(takeSecret(window), location.pathname);
addEventListener("hashchange", () => passSecretOn(window)); // another link, put into the address bar of this one
const store = createStore<VisitorState>(initialVisitor);
const view = viewActions(store);
const words = text.shared;
const CLOSED = "?closed";
let opened: SharedResult | null = null;
let asksPasscode = false;
const closings = new BroadcastChannel("breastrig-closed"); // the same result in another tab of this browser
closings.onmessage = ({ data }: MessageEvent<unknown>) => {
  if (data === opened?.id) location.replace(`/s${CLOSED}`);
};
const moment = new Intl.DateTimeFormat(locale(), { dateStyle: "long", timeStyle: "short" });

const canvas = el("canvas", { class: "view", role: "img", "aria-label": viewText.shared, tabindex: 0 });
const overlay = el("div", { class: "overlay", "aria-hidden": "true" });
const viewBar = createViewBar(view, { distances: (isOn) => store.set((state) => withDistances(state, isOn)), loose: (showLoose) => store.set({ showLoose }), relief: (showRelief) => store.set({ showRelief }), colours: (showColours) => store.set({ showColours }) }, viewBarShown);
const colourBar = createColourBar();
const note = el("p", {});
const alert = el("div", { class: "problem", role: "alert", hidden: true }, icon("alert"), note);
const waiting = el("p", { class: "muted" }, words.opening);
const passcode = el("input", { type: "password", id: "passcode", autocomplete: "off", required: true });
const form = el(
  "form",
  { class: "passcode", hidden: true, onsubmit: (event) => (event.preventDefault(), void open(passcode.value)) },
  el("p", {}, words.needsPasscode),
  el("label", { class: "field" }, el("span", {}, words.passcode), passcode),
  el("button", { class: "button primary" }, el("span", {}, words.open)),
);
const card = el("div", { class: "empty" }, el("div", { class: "empty-card busy" }, waiting, alert, form));
const host = el("div", { class: "stage" }, canvas, overlay, colourBar.element, card);
const stages = el("main", { class: "stages" }, host, viewBar.element);
const until = el("p", { class: "muted" });
const shownAs = el("p", { class: "muted" });
const planned = el("div", { class: "shared-plan" });
const lesions = createLesionList((lesion) => store.set({ lesion }));
const ofLesions = el("div", { hidden: true }, el("h2", {}, lesionText.heading), lesions.element);
const files = el("ul", { class: "files" });
const numbers = createNumbersPanel<VisitorState>();
const sureness = createSureness();
host.append(el("div", { class: "pane-caption" }, sureness.element));
const body = el("div", { class: "side-scroll shared-side", tabindex: 0 }, el("p", {}, words.what), shownAs, until, numbers.element, planned, ofLesions, el("h2", {}, resultText.files), files); // it scrolls by keys too
const side = el("aside", { class: "side", "aria-label": words.title, hidden: true }, body, el("div", { class: "side-foot" }, el("p", { class: "notice" }, noticeLong)));
const leave = button(words.close, () => void close(), "quiet outlined", "close");
const languages = otherLanguages().map(({ language, name: called }) => {
  const change = button(called, () => {
    if (opened === null) keepSecret(window, visit.secret); // the link is still to be opened
    changeLanguage(language);
  });
  change.lang = language;
  return change;
});
const top = el("header", { class: "top-bar" }, el("span", { class: "logo", "aria-hidden": "true" }), el("h1", {}, name), el("span", { class: "scan-title" }, words.title), el("span", { class: "spring" }), ...languages, leave);

document.title = `${words.title} · ${name}`;
document.body.classList.add("is-empty", "is-shared");
document.body.append(top, stages, side);
follow(store, viewBar);
follow(store, colourBar);
follow(store, numbers);
store.select(only("fit", "drawn"), (state) => sureness.update(state));
store.select(only("plan", "lesion"), ({ plan, lesion }) => {
  const laid = lesionsOnScan(plan);
  show(ofLesions, laid.length > 0);
  lesions.update({ laid, lesion });
});
show(leave, false);
if (visit.secret === "" && visit.share === "") nothingOpen();
else void open("");

/** Without a link there is nothing to show but how to open one. */
function nothingOpen(): void {
  setText(waiting, location.search === CLOSED ? words.closed : words.howToOpen);
  history.replaceState(null, "", "/s");
}

function say(sentence: string): void {
  setText(note, sentence);
  show(alert, sentence !== "");
  show(waiting, false);
}

async function open(code: string): Promise<void> {
  try {
    opened = await openLink(visit, code, history);
    show(form, false);
    show(leave, true);
    const session = await readShared(opened);
    fillSide(opened, session);
    store.set(session);
  } catch (error) {
    const status = error instanceof ApiError ? error.status : null;
    asksPasscode = opened === null && (status === 403 || (asksPasscode && (status === 429 || status === 0)));
    show(form, asksPasscode);
    say(asksPasscode && code === "" ? "" : error instanceof Error ? error.message : String(error));
    if (asksPasscode) passcode.select(); // a wrong one is typed over
    return;
  }
  show(card, false);
  show(side, true);
  document.body.classList.remove("is-empty");
  const failed = (sentence: string): void => {
    show(card, true);
    show(form, false);
    say(sentence);
  };
  try {
    openSharedViewer(store, { host, canvas, overlay }, () => failed(fitErrors.surface));
  } catch {
    failed(viewErrors.noGraphics);
  }
}

/** The next page of this tab knows nothing of this one, and going back does not lead here. */
async function close(): Promise<void> {
  if (!opened) return;
  try {
    await closeLink(opened);
  } catch (error) {
    show(card, true);
    show(form, false);
    say(error instanceof Error ? error.message : String(error));
    return;
  }
  closings.postMessage(opened.id);
  location.replace(`/s${CLOSED}`);
}

function fillSide({ expires_at, shown_at, links }: SharedResult, { fit, plan }: VisitorState): void {
  setText(until, words.until(moment.format(new Date(expires_at))));
  setText(shownAs, [...(shown_at === null ? [] : [words.shownAt(moment.format(new Date(shown_at)))]), ...(links.mesh === null ? [words.modelAlone] : []), ...(fit?.result?.predicted ? [words.predicted] : [])].join(" "));
  if (plan) planned.replaceChildren(...planList(fit?.drawing ?? null, plan));
  const offered = words.files.flatMap(({ key, name, what }) => (links[key] === null ? [] : [{ href: links[key], name, what }]));
  fill(files, offered, () =>
    offered.map(({ href, name, what }) => el("li", {}, el("a", { href, download: name }, icon("download"), el("span", {}, name)), el("span", { class: "muted" }, what))),
  );
}
