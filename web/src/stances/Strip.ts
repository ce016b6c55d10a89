// To the left: all scans of the patient.  One tap shows one, a second one beside it, another tap puts it away.
import { fingersMark, fingersOf, saidWide } from "../fit/fingers";
import { locale } from "../languages/words";
import { el, fill } from "../ui/dom";
import type { Panel } from "../ui/Panel";
import type { StancesActions } from "./actions";
import { daysOf, type StripShown, type Thumb, thumbsOf } from "./thumbs";
import * as text from "./text";

const words = text.strip;
const day = new Intl.DateTimeFormat(locale(), { day: "numeric", month: "long" });
const dayOfYear = new Intl.DateTimeFormat(locale(), { day: "numeric", month: "long", year: "numeric" });
const time = new Intl.DateTimeFormat(locale(), { hour: "2-digit", minute: "2-digit" });

/** Today, or the day as a person says it. */
export const dayName = (at: Date, now: Date): string => (isToday(at, now) ? words.today : (at.getFullYear() === now.getFullYear() ? day : dayOfYear).format(at));
export const isToday = (at: Date, now: Date): boolean => at.toDateString() === now.toDateString();

/** `pointsOf`: how many are worth checking on a fit, as far as that was asked. */
export function createStrip<More extends StripShown & { readonly isStarting: boolean }>(stances: Pick<StancesActions, "dialog" | "tap"> & { visits(): Promise<void> }, pointsOf: (state: More, fit: string) => number): Panel<{ readonly thumbs: string; readonly isBusy: boolean }, More> {
  const days = el("div", { class: "strip-days" });
  const add = el("button", { type: "button", class: "strip-add", id: "add-scan", title: words.addHint, onclick: () => stances.dialog(true) }, words.add);
  const visits = el("button", { type: "button", class: "strip-add", id: "visits", title: words.visitsHint, onclick: () => void stances.visits() }, words.visits);
  const element = el("nav", { class: "strip", "aria-label": words.label }, days);

  function thumb(of: Thumb & { readonly points: number }, isBusy: boolean): HTMLElement {
    const name = of.isImage ? words.image : words.names[of.stance];
    const about = [...(of.isPredicted ? [] : [time.format(new Date(of.at))]), ...(of.pane === null ? [] : [words.pane(of.pane)]), ...(of.mm === undefined ? [] : [words.lines(saidWide(of.mm))]), ...(of.points > 0 ? [words.points(of.points)] : [])];
    return el(
      "button",
      { type: "button", class: `thumb${of.isPredicted ? " is-predicted" : ""}`, "data-scan": of.id, "data-stance": of.isImage ? "image" : of.stance, "aria-pressed": String(of.pane !== null), "data-pane": of.pane, title: [name, ...about].join(", "), disabled: isBusy, onclick: () => void stances.tap(of.id, matchMedia("(width < 560px)").matches) },
      el("img", { src: of.picture, alt: "", width: 71, height: 68, onerror: ({ target }) => ((target as HTMLElement).style.visibility = "hidden") }),
      el("span", { class: "thumb-name" }, el("span", {}, of.isPredicted ? words.predicted : name), of.mm === undefined ? null : fingersMark(fingersOf(of.mm)), el("span", { class: "visually-hidden" }, ["", ...about].join(", "))),
      of.pane === null ? null : el("span", { class: "thumb-pane", "aria-hidden": "true" }, String(of.pane)),
    );
  }

  return {
    element,
    select: (state) => ({ thumbs: JSON.stringify(thumbsOf(state).map((each) => ({ ...each, points: each.fit === null ? 0 : pointsOf(state, each.fit) }))), isBusy: state.isStarting }),
    update({ thumbs, isBusy }): void {
      const held = document.activeElement?.closest<HTMLElement>(".thumb")?.dataset.scan;
      fill(days, [thumbs, isBusy], () => {
        const all = daysOf(JSON.parse(thumbs) as (Thumb & { points: number })[]);
        const scanned = all.flatMap(([, of]) => of).filter(({ isPredicted }) => !isPredicted).length;
        return all.length === 0 ? [add] : all.map(([at, of], i) => el("section", { class: "strip-day" }, el("h2", {}, [dayName(new Date(at), new Date()), ...new Set(of.map(({ visit }) => visit).filter((visit) => visit !== ""))].join(", ")), ...of.map((each) => thumb(each, isBusy)), i === 0 ? add : null, i === 0 && scanned > 1 ? visits : null));
      });
      if (held) days.querySelector<HTMLElement>(`[data-scan="${CSS.escape(held)}"]`)?.focus();
    },
  };
}
