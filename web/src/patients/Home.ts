// The first page: all patients as cards, and where the scans of another one are let go.
import type { Patient } from "../api/types";
import type { PageSlice } from "../store/page";
import { only } from "../store/store";
import type { ScanSlice } from "../scan/state";
import { ANY_FILE, button, filesButton, problem, select } from "../ui/controls";
import { el, fill, icon, setText, show } from "../ui/dom";
import { createMenu, menuItem } from "../ui/menu";
import type { Panel } from "../ui/Panel";
import { allGroups, groupsForNew, mayPlan } from "../store/person";
import { formatMegabytes } from "../ui/units";
import type { PatientActions } from "./actions";
import { patientCard } from "./PatientCard";
import { type Order, type PatientsSlice, sureness } from "./state";
import * as text from "./text";

const words = text.home;

type Shown = PatientsSlice & Pick<PageSlice & ScanSlice, "scan" | "meta" | "group" | "examples" | "problems">;

/** How scans come in: files, or examples by name. */
export interface Bringing {
  readonly files: (files: readonly File[]) => void;
  readonly examples: (names: readonly string[]) => void;
}

/** A code is being typed in the card, or it asks whether to delete. */
const isAsking = (card: HTMLElement): boolean => card.querySelector(".patient-code:not([hidden]), .sure:not([hidden])") !== null;

/** `addressOf`: the address that opens the patient's scans with their newest fits. */
export function createHome(patients: PatientActions, bring: Bringing, addressOf: (patient: Patient) => string, dismiss: (place: "scan" | "service") => void): Panel<Shown> {
  const search = el("input", { type: "search", class: "search", placeholder: words.search, "aria-label": words.search, oninput: () => patients.search(search.value) });
  const orders = Object.entries(words.orders).map(([value, label]) => ({ value: value as Order, label }));
  const order = select<Order>(words.order, (by) => void patients.order(by), "field inline");
  const fresh = filesButton(words.fresh, ANY_FILE, "primary", bring.files);
  fresh.querySelector("input")!.id = "scan-file";
  const group = select(words.groupOfNew, (chosen) => patients.chooseGroup(chosen), "field inline");
  const reader = el("p", { class: "muted", hidden: true }, words.mayLook);
  const limit = el("p", { class: "muted small" });
  const examples = createMenu("example-menu", words.example, words.exampleHint, "outlined");
  const wrong = problem(() => dismiss("scan"));
  const service = problem(() => dismiss("service"));
  const drop = el("div", { class: "drop-zone" }, icon("upload"), el("div", {}, el("h2", {}, words.drop), limit), examples.element);
  const list = el("ul", { class: "patients", "aria-label": words.title });
  const none = el("p", { class: "muted", hidden: true });
  const more = button(words.more, () => void patients.more(), "outlined");
  const head = el("div", { class: "home-head" }, el("h1", {}, words.title), search, order.element, el("span", { class: "spring" }), fresh);
  const noticed = el("p", { class: "home-notice is-out" }, words.notice);
  const element = el("div", { class: "home" }, el("div", { class: "home-page" }, head, reader, wrong.element, service.element, drop, list, none, more, noticed));

  /** The list's cards, in this order.  One in which something is typed stays in the document: else it would lose the focus. */
  function arrange(wanted: readonly HTMLElement[]): void {
    for (const card of [...list.children]) if (!wanted.includes(card as HTMLElement)) card.remove();
    wanted.forEach((card, i) => {
      if (isAsking(card) && card.parentElement === list) while (list.children[i] !== card) list.append(list.children[i]!);
      else if (list.children[i] !== card) list.insertBefore(card, list.children[i] ?? null);
    });
  }

  function exampleItem(name: string, label: string): HTMLButtonElement {
    const item = menuItem(label, "", () => bring.examples([name]));
    item.dataset.example = name;
    return item;
  }

  let written: unknown[] = [];
  let made = new Map<string, HTMLElement>(); // cards by what they show
  return {
    element,
    select: only("patients", "scan", "meta", "group", "examples", "problems"),
    update({ patients: state, scan, meta, group: chosen, examples: known, problems }: Shown): void {
      const { rows, next, search: sought, order: by, isKnown, isBusy, points, going } = state;
      show(element, scan === null);
      const isReader = !mayPlan({ meta });
      for (const each of [fresh, drop]) show(each, !isReader);
      show(reader, isReader);
      const offered = groupsForNew(meta);
      if (offered.length === 0 || isReader) group.element.remove();
      else if (group.element.parentElement === null) fresh.before(group.element);
      group.set([{ value: "", label: allGroups(meta).length > 0 && (meta?.person?.groups.length ?? 0) < 2 ? words.groupNone : words.groupChoose }, ...offered.map((each) => ({ value: each, label: each }))], chosen);
      setText(limit, words.limit(meta ? formatMegabytes(meta.limits.upload_bytes) : null, meta ? formatMegabytes(meta.limits.zip_bytes) : null));
      examples.element.classList.toggle("is-out", known.length === 0);
      const together = known.filter(({ stance }, i) => known.findIndex((each) => each.stance === stance) === i).map(({ name }) => name); // one of each stance
      fill(examples.card, known, () =>
        [...(together.length > 1 ? [menuItem(words.allExamples, "", () => bring.examples(together))] : []), ...known.map(({ name, label }) => exampleItem(name, label))].map((item) => {
          item.addEventListener("click", () => examples.close());
          return item;
        }),
      );
      wrong.set(scan ? undefined : problems.scan);
      service.set(problems.service);
      for (const each of [search, order.element]) each.classList.toggle("is-out", !isKnown || (rows.length === 0 && sought === ""));
      order.set(orders, by);
      noticed.classList.toggle("is-out", !isKnown && problems.service === undefined);
      const now = [rows, points, going, meta];
      if (now.some((each, i) => each !== written[i])) {
        // A card that shows the same, or in which something is being typed or asked, stays itself, whatever comes meanwhile.
        const before = made;
        made = new Map(
          rows.map((each): [string, HTMLElement] => {
            const isGoing = going.includes(each.id);
            const asking = isGoing ? undefined : ([...list.children] as HTMLElement[]).find((card) => card.dataset.patient === each.id && isAsking(card));
            if (asking) return [`asks ${each.id}`, asking];
            const shown = JSON.stringify([each, points[sureness(each).fit ?? ""], isGoing, meta === null]);
            return [shown, before.get(shown) ?? patientCard(each, isGoing, patients, points, addressOf(each), meta)];
          }),
        );
        const wanted = [...made.values()];
        arrange(wanted);
      }
      written = now;
      setText(none, words.none(sought));
      show(none, rows.length === 0 && sought !== "" && !isBusy);
      show(more, next !== null);
      more.disabled = isBusy;
    },
  };
}
