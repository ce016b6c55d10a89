// What is given away: the report first, a link, measures, files for programs.
import { result as resultText } from "../fit/text";
import { only } from "../store/store";
import { button } from "../ui/controls";
import { el, fill, icon, show } from "../ui/dom";
import type { Panel } from "../ui/Panel";
import type { Actions } from "./actions";
import type { Session } from "./session";
import * as text from "./text";

const words = text.handover;

type Shown = Pick<Session, "scan" | "fit" | "drawn">;

export function createHandOver(actions: Actions): Panel<Shown> {
  const share = button(words.share, () => void actions.share.open(), "outlined wide", "link");
  share.id = "share";
  share.title = words.shareHint;
  const measures = button(words.measures, () => void actions.stances.measures(true), "outlined wide", "tape");
  measures.id = "measures";
  measures.title = words.measuresHint;
  const files = el("ul", { class: "files" });
  const table = button(text.files.distances, actions.files.saveDistances, "link", "download");
  table.title = text.files.distancesHint;
  const lines = button(text.files.lines, actions.files.saveLines, "link", "download");
  lines.title = text.files.linesHint;
  const done = el("div", { class: "panel" }, share, measures, el("details", { class: "file-list", open: true }, el("summary", {}, words.files), files, table));
  const none = el("p", { class: "muted" }, words.none);
  const element = el("div", { class: "panel" }, none, done, lines);
  return {
    element,
    select: only("scan", "fit", "drawn"),
    update({ fit, drawn }: Shown): void {
      show(lines, drawn.lines.present.length > 0);
      const isDone = fit?.state === "done";
      show(none, !isDone);
      show(done, isDone);
      if (!fit || !isDone) return;
      show(table, fit.distances !== null);
      fill(files, fit.id, () =>
        resultText.downloads.map(({ key, name, what }) =>
          el("li", {}, el("a", { href: fit.links[key], download: name }, icon("download"), el("span", {}, name)), el("span", { class: "muted" }, what)),
        ),
      );
    },
  };
}
