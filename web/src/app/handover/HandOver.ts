// Beside the printed pages: what is not checked yet, a link, measures, files for programs.
import { client } from "../../api/client";
import { result as resultText } from "../../fit/text";
import { messageOf } from "../../store/problems";
import { only } from "../../store/store";
import { button } from "../../ui/controls";
import { el, fill, icon, show } from "../../ui/dom";
import type { Panel } from "../../ui/Panel";
import type { Actions } from "../actions";
import * as text from "../text";
import { toArchive as archiveWords } from "./text";
import { type Unchecked, uncheckedOf } from "./unchecked";

const words = text.handover;

export type HandOverShown = Parameters<typeof uncheckedOf>[0];

export function createHandOver(actions: Actions): Panel<HandOverShown> {
  const share = button(words.share, () => void actions.share.open(), "outlined wide", "link");
  share.id = "share";
  share.title = words.shareHint;
  const measures = button(words.measures, () => void actions.stances.measures(true), "outlined wide", "tape");
  measures.id = "measures";
  measures.title = words.measuresHint;
  const template = ofPlan("template", "outlined wide");
  const guides = el("div", { class: "toolbar" }, ofPlan("right", "link"), ofPlan("left", "link"));
  const files = el("ul", { class: "files" });
  const table = button(text.files.distances, actions.files.saveDistances, "link", "download");
  table.title = text.files.distancesHint;
  const lines = button(text.files.lines, actions.files.saveLines, "link", "download");
  lines.title = text.files.linesHint;
  const none = el("p", { class: "muted" }, words.none);
  const list = el("ul", { class: "unchecked" });
  const before = el("section", { class: "panel", "aria-label": words.before }, el("h2", {}, words.before), list);
  const forPrograms = el("details", { class: "file-list" }, el("summary", {}, words.files), files, table, lines, guides, ofPlan("dicom", "link"));
  const archives = el("div", { class: "panel", role: "status" });
  const done = el("div", { class: "panel" }, before, el("h2", {}, words.handOn), share, measures, template, archives);
  const element = el("div", { class: "panel hand-over" }, none, done, forPrograms);

  function ofPlan(kind: text.OfPlan, look: string): HTMLButtonElement {
    const made = button(words.ofPlan[kind][0], () => void save(), look, "download");
    const save = async (): Promise<void> => {
      made.disabled = true; // it takes some seconds
      await actions.files.saveOfPlan(kind);
      made.disabled = false;
    };
    made.id = `of-plan-${kind}`;
    made.title = words.ofPlan[kind][1];
    return made;
  }

  function toArchive(report: string, archive: string): readonly HTMLElement[] {
    const said = el("p", { class: "muted" });
    const send = button(archiveWords.send(archive), () => void run(), "outlined wide", "link");
    const run = async (): Promise<void> => {
      send.disabled = true;
      said.textContent = archiveWords.archiving;
      const answer = client.toArchive(report, archive).then((notes) => archiveWords.archived(archive, notes).trim());
      said.textContent = await answer.catch(messageOf);
      send.disabled = false;
    };
    send.title = archiveWords.hint;
    return [send, said];
  }

  async function go({ way, isOther }: Unchecked): Promise<void> {
    if (way === "scan") actions.stances.dialog(true);
    if (isOther && way !== "scan") await actions.stances.swap();
    if (way === "check") actions.checks.begin();
    if (way === "points" || way === "plan") actions.page.goTo(way);
  }

  return {
    element,
    select: only("asked", "meta", "step", "loading", "scan", "confirmed", "picks", "certain", "proposals", "skipped", "active", "fit", "isStarting", "stance", "preset", "refine", "drawing", "drawn", "ink", "stances", "checks", "overlay"),
    update(state: HandOverShown): void {
      const { fit, drawn } = state;
      const isDone = fit?.state === "done";
      show(none, !isDone);
      show(done, isDone);
      show(guides, isDone);
      show(lines, drawn.lines.present.length > 0);
      show(table, isDone && fit.distances !== null);
      show(forPrograms, isDone || drawn.lines.present.length > 0);
      const named = isDone ? (state.meta?.archives ?? []) : [];
      fill(archives, isDone ? [fit.id, ...named].join() : "", () => named.flatMap((archive) => toArchive(fit?.links.report ?? "", archive)));
      const unchecked = isDone ? uncheckedOf(state) : [];
      fill(list, unchecked, () => unchecked.map((each) => el("li", { class: each.isReady ? "is-ready" : "" }, el("span", {}, each.says), each.way === null ? null : button(words.ways[each.way], () => void go(each), "link"))));
      fill(files, isDone ? fit.id : "", () =>
        isDone ? resultText.downloads.map(({ key, name, what }) => el("li", {}, el("a", { href: fit.links[key], download: name }, icon("download"), el("span", {}, name)), el("span", { class: "muted" }, what))) : [],
      );
    },
  };
}
