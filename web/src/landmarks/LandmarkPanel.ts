// The landmarks in order.  A row shows what it is, on which side, whether it is placed; pressing it (re-)places it.
import type { LandmarkDefinition } from "../api/types";
import type { ScanSlice } from "../scan/state";
import type { PageSlice } from "../store/page";
import { only } from "../store/store";
import { button, fileButton, iconButton, problem } from "../ui/controls";
import { el, fill, icon, setText, show } from "../ui/dom";
import { createMenu, menuItem } from "../ui/menu";
import type { Panel } from "../ui/Panel";
import type { LandmarkActions } from "./actions";
import { isCertain } from "./certain";
import { createMarkList } from "./marks/MarkList";
import type { AskedOfMarks, MarksSlice } from "./marks/marks";
import { LANDMARK_ENDINGS, partnerOf, plainLabel, sideOf } from "./picks";
import { onlyAgreed } from "./proposals/agreed";
import { errorOf, isLikely, isSeen, type OpenProposal, openProposals } from "./proposals/proposals";
import type { ProposalSearch } from "./proposals/proposalSearch";
import { createQuestionBox } from "./questions/QuestionBox";
import { type Asked, askedNames, openQuestions, type Question } from "./questions/questions";
import type { LandmarksSlice } from "./state";
import * as text from "./text";

type Shown = Pick<PageSlice & ScanSlice & LandmarksSlice & MarksSlice, "meta" | "problems" | "scan" | "picks" | "certain" | "proposals" | "skipped" | "active" | "saving" | "beside"> & Pick<Asked, "fit"> & AskedOfMarks;

export function createLandmarkPanel(actions: LandmarkActions, search: ProposalSearch, dismiss: () => void): Panel<Shown> {
  const rows = el("ol", { class: "landmarks" });
  const again = button(text.landmarks.again, () => void actions.saveNow(), "link");
  const wrong = problem(dismiss);
  const example = button(text.landmarks.useExample, () => actions.useExample(), "quiet outlined wide");
  let state: Shown | null = null;
  const file = fileButton(text.landmarks.importFile, LANDMARK_ENDINGS.join(), "icon-only", (chosen) => void actions.importFile(chosen));
  file.querySelector("input")!.id = "landmark-file";
  file.querySelector("span")!.className = "visually-hidden";
  file.title = text.landmarks.importHint;
  const save = createMenu("landmark-export", "", text.landmarks.exportHint, "icon-only", ...Object.entries(text.landmarks.exported).map(([kind, hint]) =>
    menuItem(`landmarks.${kind}`, hint, () => {
      save.close();
      void actions.exportFile(kind);
    })));
  save.open.prepend(icon("download"));
  const exchangeAll = iconButton("exchange", text.landmarks.exchangeAll, () => actions.exchange(paired(state)));
  const ofAll = createQuestionBox("div", actions, () => file.focus());
  const proposals = makeProposals(actions, search);
  const marks = createMarkList(actions);
  const element = el(
    "div",
    { class: "panel" },
    wrong.element,
    el("div", { class: "toolbar" }, exchangeAll, el("span", { class: "spring" }), again, file, save.element),
    proposals.element,
    ofAll.element,
    rows,
    marks.element,
    example,
  );
  const made = new Map<string, ReturnType<typeof makeRow>>();
  return {
    element,
    select: only("meta", "problems", "scan", "picks", "certain", "proposals", "skipped", "active", "saving", "beside", "fit", "drawn"),
    update(session: Shown): void {
      state = session;
      const list = session.meta?.landmarks ?? [];
      fill(rows, list.map(({ name, label }) => [name, label]), () => {
        made.clear();
        for (const entry of list) made.set(entry.name, makeRow(entry, made.size + 1, actions));
        return [...made.values()].flatMap((each) => [each.element, each.question.element]);
      });
      const questions = openQuestions(session);
      const asked = askedNames(questions);
      const open = new Map(openProposals(session.proposals, session.picks.present).map((proposal) => [proposal.name, proposal]));
      for (const [name, each] of made) each.update(session, asked.has(name), open.get(name) ?? null);
      const placed = new Map(questions.map((question) => [rowOf(question, list), question]));
      for (const [name, each] of made) each.question.update(placed.get(name) ?? null, list);
      ofAll.update(questions.find(({ exchange }) => exchange === "all") ?? null, list);
      proposals.update(session, [...open.values()]);
      marks.update(session);
      const isEmpty = Object.keys(session.picks.present).length === 0;
      save.open.disabled = isEmpty;
      exchangeAll.disabled = paired(session).length === 0;
      wrong.set(session.problems.landmarks);
      show(again, session.saving === "unsaved" && session.problems.landmarks !== undefined);
      show(example, Boolean(session.scan?.example));
    },
  };
}

/** Placed landmarks whose partner on the other side is placed as well. */
function paired(state: Pick<Shown, "picks"> | null): string[] {
  const present = state?.picks.present ?? {};
  return Object.keys(present).filter((name) => sideOf(name) !== "middle" && partnerOf(name) in present);
}

/** Below which row a question stands: the last of those that it names; one about all sides stands above the list. */
function rowOf({ names, exchange }: Question, list: readonly LandmarkDefinition[]): string | null {
  return exchange === "all" ? null : (list.findLast(({ name }) => names.includes(name))?.name ?? null);
}

function makeRow(entry: LandmarkDefinition, number: number, actions: LandmarkActions) {
  const side = sideOf(entry.name);
  const status = el("span", { class: "visually-hidden" });
  const chip = side === "middle" ? null : el("span", { class: `chip side-${side}`, title: text.landmarks.sides[side] }, el("span", { "aria-hidden": "true" }, text.landmarks.sideShort[side]), el("span", { class: "visually-hidden" }, text.landmarks.sideWords[side]));
  const place = el(
    "button",
    {
      type: "button",
      class: "landmark-name",
      title: `${entry.latin}\n${entry.definition}`,
      onclick: () => actions.want(entry.name),
    },
    el("span", { class: `mark side-${side}` }, el("span", {}, String(number))),
    el("span", { class: "label-text" }, plainLabel(entry.label)),
    chip,
    status,
  );
  const remove = iconButton("close", text.landmarks.remove(text.landmarks.spoken(entry)), () => actions.remove(entry.name));
  remove.classList.add("remove");
  const exchange = iconButton("exchange", text.landmarks.exchange(plainLabel(entry.label)), () => actions.exchange([entry.name, partnerOf(entry.name)]));
  exchange.classList.add("exchange");
  const kept = el("button", { type: "button", class: "button kept", title: text.questions.keptHint(text.landmarks.spoken(entry)), "aria-label": text.questions.keptHint(text.landmarks.spoken(entry)), onclick: () => actions.unkeep(entry.name) }, text.questions.kept);
  const agreed = el("button", { type: "button", class: "button kept agreed", onclick: () => actions.want(entry.name) }, text.proposals.agreed);
  const confirm = el("button", { type: "button", class: "button confirm", onclick: () => actions.confirm([entry.name]) }, icon("check"), el("span", {}));
  const words = confirm.querySelector("span")!;
  words.classList.add("pm");
  const element = el("li", { class: "landmark", "data-landmark": entry.name }, place, kept, agreed, icon("check"), icon("alert"), confirm, exchange, remove);
  const question = createQuestionBox("li", actions, () => place.focus());
  return {
    element,
    question,
    update(state: Shown, isAsked: boolean, proposal: OpenProposal | null): void {
      const isPlaced = entry.name in state.picks.present;
      const isSkipped = state.skipped.has(entry.name) && !isPlaced;
      const isActive = state.active === entry.name;
      if (isActive && !element.classList.contains("is-active")) element.scrollIntoView({ block: "nearest" });
      element.classList.toggle("is-placed", isPlaced);
      element.classList.toggle("is-skipped", isSkipped);
      element.classList.toggle("is-active", isActive);
      const isKept = isCertain(state.picks.present, state.certain, entry.name);
      const isAgreed = entry.name in onlyAgreed(state);
      element.classList.toggle("is-agreed", isAgreed);
      element.classList.toggle("is-asked", isAsked);
      show(agreed, isAgreed);
      const own = state.proposals?.state === "found" ? state.proposals.landmarks[entry.name] : undefined;
      const hint = text.proposals.agreedHint(text.landmarks.spoken(entry), own ? errorOf(own) : null);
      agreed.title = hint;
      agreed.setAttribute("aria-label", hint);
      element.classList.toggle("is-kept", isKept);
      show(kept, isKept);
      place.setAttribute("aria-pressed", String(isActive));
      show(remove, isPlaced);
      show(exchange, isPlaced && side !== "middle" && partnerOf(entry.name) in state.picks.present);
      const mm = proposal ? (errorOf(proposal) ?? text.proposals.unknown) : "";
      element.classList.toggle("is-proposed", proposal !== null);
      show(confirm, proposal !== null);
      confirm.classList.toggle("is-rough", proposal !== null && !isLikely(proposal));
      setText(words, text.proposals.errorShort(mm));
      confirm.title = proposal?.on_scan === false ? text.proposals.offScanHint : text.proposals.errorHint(mm, proposal?.reason);
      confirm.setAttribute("aria-label", `${text.proposals.confirm(text.landmarks.spoken(entry))}, ${text.proposals.error(mm)}`);
      const missing = proposal ? text.proposals.rowState(mm, proposal.reason) : text.landmarks.missing;
      const placed = isAsked ? text.questions.state : isKept ? text.questions.keptState : isAgreed ? text.proposals.agreedState : text.landmarks.placed;
      setText(status, isPlaced ? placed : isSkipped ? text.landmarks.skippedState : missing);
    },
  };
}

/** Above the list: what the service proposes, and the one press that takes what the skin's colours show. */
function makeProposals(actions: LandmarkActions, search: ProposalSearch) {
  const words = el("span", {});
  const room = el("span", { class: "room", "aria-hidden": "true" }); // as much as the longest of them needs: the list does not move when the answer comes
  let seen: readonly string[] = [];
  const take = button("", () => actions.confirm(seen), "quiet outlined");
  const again = button(text.proposals.again, () => void search.look(), "quiet outlined");
  const missing = el("div", { class: "muted small" });
  const element = el("div", { class: "proposals", hidden: true }, el("p", {}, words, room), take, again, missing);
  return {
    element,
    update({ meta, proposals, active }: Shown, open: readonly OpenProposal[]): void {
      const isNone = proposals?.state === "none";
      seen = open.filter(isSeen).map(({ name }) => name);
      const absent = proposals?.state === "found" ? Object.entries(proposals.not_proposed) : [];
      const rough = open.filter((proposal) => !isLikely(proposal)).length;
      show(element, proposals?.state === "looking" || isNone || open.length > 0 || absent.length > 0);
      fill(missing, absent, () =>
        [...new Set(absent.map(([, why]) => why))].map((reason) => {
          const names = new Set(absent.filter(([, why]) => why === reason).map(([name]) => name));
          return el("p", {}, text.proposals.notProposed((meta?.landmarks ?? []).filter(({ name }) => names.has(name)).map((entry) => text.landmarks.spoken(entry)), reason));
        }),
      );
      const found = open.length === 0 ? "" : text.proposals.found(open.length, rough);
      setText(room, text.proposals.found(meta?.landmarks.length ?? 0, 1));
      setText(words, proposals?.state === "none" ? text.proposals.none(proposals.reason) : proposals?.state === "looking" ? text.proposals.looking : found);
      show(take, seen.length > 0 && active !== null); // else the large button offers it
      setText(take.querySelector("span")!, text.proposals.confirmSeen(seen.length));
      show(again, isNone);
    },
  };
}
