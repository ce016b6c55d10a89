// The printed pages as they will be, in place of the stage; printing prints them, in true size.
import { client } from "../../api/client";
import { measuredFits } from "../../stances/state";
import { messageOf } from "../../store/problems";
import { only } from "../../store/store";
import { el, fill, setText, show } from "../../ui/dom";
import type { Panel } from "../../ui/Panel";
import type { Session } from "../session";
import { handover as words } from "../text";
import "./paper.css";

export type PaperShown = Pick<Session, "step" | "scan" | "fit" | "drawn" | "stances">;

/** report.pdf of both stances that are done. */
export function reportLink(state: Pick<PaperShown, "fit" | "stances">): string | null {
  const fits = measuredFits(state);
  return fits && fits[0].links.report + (fits[1] ? `?with=${encodeURIComponent(fits[1].id)}` : "");
}

let ready: Promise<unknown> = Promise.resolve(); // the pages that were asked for last

/** Prints the pages as soon as they are here. */
export async function printPages(): Promise<void> {
  await ready;
  if (document.querySelector(".paper img")) window.print();
}

export function createPaper(): Panel<PaperShown> {
  const says = el("p", { class: "paper-says", role: "status" });
  const pages = el("div", { class: "paper-pages" });
  const element = el("section", { class: "paper", "aria-label": words.pages, tabindex: 0, hidden: true }, says, pages);
  let shown: unknown[] = [];
  let pictures: string[] = [];

  function put(found: readonly Blob[]): void {
    pictures.forEach((each) => URL.revokeObjectURL(each));
    pictures = found.map((each) => URL.createObjectURL(each));
    fill(pages, pictures, () => pictures.map((src, i) => el("img", { src, alt: words.page(i + 1, pictures.length) })));
  }

  async function load(report: string, asked: unknown[]): Promise<void> {
    setText(says, words.making);
    try {
      const first = await client.reportPage(report, 1);
      if (shown !== asked) return;
      put([first.picture]);
      const more = await Promise.all(Array.from({ length: first.count - 1 }, (_, i) => client.reportPage(report, i + 2)));
      if (shown !== asked) return;
      put([first.picture, ...more.map(({ picture }) => picture)]);
      setText(says, "");
      await Promise.all([...pages.querySelectorAll("img")].map((each) => each.decode()));
    } catch (error) {
      if (shown !== asked) return;
      put([]);
      shown = []; // the next change asks again
      setText(says, messageOf(error));
    }
  }

  return {
    element,
    select: only("step", "scan", "fit", "drawn", "stances"),
    update(state: PaperShown): void {
      const report = state.step === "handover" && state.scan ? reportLink(state) : null;
      show(element, report !== null && !state.stances.measures.isOpen);
      if (report === null || state.drawn.saving !== "saved") return;
      const now = [report, state.drawn.lines.present, state.drawn.note, state.drawn.depthMm, state.drawn.lesions, state.drawn.onScan?.plan, state.scan!.info.patient_code];
      if (now.every((each, i) => each === shown[i])) return;
      shown = now;
      ready = load(report, now);
    },
  };
}
