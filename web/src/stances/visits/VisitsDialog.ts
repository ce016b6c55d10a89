// Visits: the day of each scan, measures over the days, and where the skin changed between two of them.
import "./visits.css";
import type { ScanVisit, VisitsFile } from "../../api/types";
import { capital, locale } from "../../languages/words";
import type { ScanSlice } from "../../scan/state";
import type { PageSlice } from "../../store/page";
import { only } from "../../store/store";
import { button, iconButton, problem } from "../../ui/controls";
import { el, fill, icon, show } from "../../ui/dom";
import type { Panel } from "../../ui/Panel";
import { close as closeText } from "../../ui/text";
import { formatFixed, formatSignedMm } from "../../ui/units";
import { errors as viewErrors } from "../../viewer/text";
import type { PatientScan, StancesSlice } from "../state";
import type { VisitsActions } from "./actions";
import * as text from "./text";

const words = text.visits;
const SIDES = ["left", "right"] as const;
const NAMES = "visit-names";
const LONGEST = 60; // characters of a visit's name
const FIRST_DAY = "1900-01-01"; // of the service

type Shown = Pick<PageSlice & ScanSlice & StancesSlice, "problems" | "scan" | "stances">;
type Stance = VisitsFile["stances"][number];

export function createVisitsDialog(actions: VisitsActions, dismiss: () => void): Panel<Shown> {
  const received = new Intl.DateTimeFormat(locale(), { dateStyle: "medium", timeStyle: "short" });
  const turned = new Map<HTMLElement, () => void>(); // bodies that are shown, and what takes them away
  const leaveBodies = (): void => {
    for (const leave of turned.values()) leave();
    turned.clear();
  };
  const close = (): void => {
    leaveBodies();
    actions.close();
  };
  const list = el("ul", { class: "visit-scans" });
  const asked = el("p", { class: "look-here" }, words.asked);
  const busy = el("p", { class: "muted", role: "status" }, words.busy);
  const none = el("p", { class: "muted" }, words.none);
  const shown = el("div", { class: "visit-stances" });
  const wrong = problem(dismiss);
  const element = el(
    "dialog",
    { class: "help visits", "aria-labelledby": "visits-title", onclose: close },
    el("div", { class: "dialog-head" }, el("h2", { id: "visits-title" }, words.title), iconButton("close", closeText, close)),
    el("p", { class: "muted" }, words.what),
    wrong.element,
    el("datalist", { id: NAMES }, ...words.names.map((value) => el("option", { value }))),
    list,
    asked,
    busy,
    none,
    shown,
  );

  function row({ id, stance, created_at, thumbnail }: PatientScan, visit: ScanVisit | undefined): HTMLElement {
    const day = el("input", { type: "date", min: FIRST_DAY, value: visit?.date ?? "", "aria-label": words.day });
    const name = el("input", { type: "text", list: NAMES, maxlength: LONGEST, value: visit?.label ?? "", placeholder: words.name, "aria-label": words.name });
    const say = (): void => void actions.say(id, day.value, name.value);
    day.addEventListener("change", () => day.validity.valid && say()); // else its year is being typed
    name.addEventListener("change", () => day.reportValidity() && say()); // half a day is asked for, and not taken for none
    day.addEventListener("blur", () => day.validity.rangeUnderflow && say()); // the service says why not
    return el("li", { "data-scan": id }, el("img", { src: thumbnail, alt: "", width: 48, height: 46 }), el("span", {}, `${capital(stance)}, ${received.format(new Date(created_at))}`), day, name);
  }

  /** In place of its picture, the map on a body. */
  async function turn(host: HTMLElement, picture: HTMLElement, asks: HTMLButtonElement, address: string, earlier: string): Promise<void> {
    asks.disabled = true;
    const found = await actions.change(address, earlier);
    asks.disabled = false;
    const isGone = (): boolean => !host.isConnected || !element.open;
    if (!found || isGone()) return;
    const { openChange } = await import("./ChangeView");
    show(host, true);
    try {
      const leave = await openChange(host, found.glb, found.frame);
      leaveBodies(); // one at a time
      if (isGone()) {
        leave();
        return;
      }
      show(picture, false);
      show(asks, false);
      turned.set(host, () => {
        leave();
        show(host, false);
        show(picture, true);
        show(asks, true);
      });
      host.querySelector("canvas")?.focus();
    } catch {
      show(host, false);
      wrong.set(viewErrors.noGraphics);
    }
  }

  return {
    element,
    select: only("problems", "scan", "stances"),
    update(state: Shown): void {
      const { scans, visits } = state.stances;
      if (visits.isOpen && !element.open) element.showModal();
      if (!visits.isOpen && element.open) element.close();
      if (!visits.isOpen) return;
      const { days, file, isBusy } = visits;
      wrong.set(state.problems.stances);
      fill(list, [scans.map(({ id, stance }) => [id, stance]), days], () => scans.map((each) => row(each, days?.find(({ scan }) => scan === each.id))));
      show(asked, (file?.asked.length ?? 0) > 0);
      show(busy, isBusy);
      show(none, !isBusy && file?.stances.length === 0);
      const place = `/api/patients/${encodeURIComponent(state.scan?.info.patient ?? "")}`;
      fill(shown, [place, file], () => {
        leaveBodies();
        return (file?.stances ?? []).map((each) => stanceOf(each, place, turn));
      });
    },
  };
}

function called({ date, label }: Stance["visits"][number]): string {
  const day = new Intl.DateTimeFormat(locale(), { dateStyle: "medium", timeZone: "UTC" }).format(new Date(date)); // a day without a time is one of UTC
  return label === "" ? day : `${day}, ${label}`;
}

/** A part of pictures' addresses, so that no earlier one is shown for another day, name or fit. */
let drawn = Date.now();

type Turn = (host: HTMLElement, picture: HTMLElement, asks: HTMLButtonElement, address: string, earlier: string) => Promise<void>;

function mapOf(earlier: string, pair: string, place: string, turn: Turn): HTMLElement[] {
  const address = `${place}/change.glb?${pair}`;
  const picture = el("img", { class: "visit-map", src: `${place}/change.png?${pair}&drawn=${drawn}`, alt: words.map, loading: "lazy" });
  const host = el("div", { class: "visit-body", hidden: true });
  const asks = button(words.turn, () => void turn(host, picture, asks, address, earlier), "outlined");
  return [picture, host, el("p", { class: "muted small" }, words.colours), el("div", { class: "buttons-row" }, asks, el("a", { class: "button outlined", href: address, download: words.file }, icon("download"), el("span", {}, words.file)))];
}

function stanceOf(of: Stance, place: string, turn: Turn): HTMLElement {
  drawn += 1;
  return el(
    "section",
    {},
    el("img", { class: "visit-plots", src: `${place}/visits.svg?stance=${of.stance}&drawn=${drawn}`, alt: words.plots(of.stance) }),
    ...of.changes.map((change) => {
      const [earlier, later] = [of.visits[change.earlier]!, of.visits[change.later]!];
      const pair = `scan=${encodeURIComponent(earlier.scan)}&with=${encodeURIComponent(later.scan)}`;
      return el(
        "section",
        { class: "visit-change" },
        el("h3", {}, words.between(capital(of.stance), called(earlier), called(later))),
        el("ul", {}, ...saidOf(change).map((sentence) => el("li", {}, sentence))),
        ...[...change.doubts, change.missing ?? ""].filter((each) => each !== "").map((each) => el("p", { class: "look-here" }, each)),
        ...(change.map === null ? [] : mapOf(earlier.scan, pair, place, turn)),
      );
    }),
  );
}

/** Of each breast the change of its volume with its band, and the largest change of its skin, if any is said. */
export function saidOf(change: Stance["changes"][number]): string[] {
  const volume = change.measures.find(({ measure }) => measure === "volume") as { said?: Partial<Record<string, string>> } | undefined;
  return SIDES.flatMap((side) => {
    const ml = volume?.said?.[side];
    const of = change.map?.[side];
    const skin = of?.half_band_mm == null ? [] : [of.largest_mm === null ? words.unsaid(words[side], formatFixed(of.half_band_mm, 1)) : words.largest(words[side], formatSignedMm(of.largest_mm), formatFixed(of.half_band_mm, 1))];
    return [...(ml === undefined ? [] : [words.volume(words[side], ml)]), ...skin];
  });
}
