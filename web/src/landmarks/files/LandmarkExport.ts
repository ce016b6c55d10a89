// The placed landmarks as a file, in four kinds.  A popover below its button, or above it where there is no room.
import { fileName, type ScanSlice } from "../../scan/state";
import { el, icon, saveFile } from "../../ui/dom";
import { certainNames } from "../certain";
import { onlyAgreed } from "../proposals/agreed";
import type { LandmarksSlice } from "../state";
import * as text from "../text";

const words = text.landmarks;
const GAP = 4; // pixels between button and menu

const KINDS = [
  { ending: "json", hint: words.exportJson, type: "application/json", made: "toJson" },
  { ending: "csv", hint: words.exportCsv, type: "text/csv", made: "toCsv" },
  { ending: "pp", hint: words.exportPp, type: "application/xml", made: "toMeshlab" },
  { ending: "mrk.json", hint: words.exportSlicer, type: "application/json", made: "toSlicer" },
] as const;

export function landmarkExport(current: () => Pick<ScanSlice & LandmarksSlice, "scan" | "picks" | "certain" | "proposals"> | null): { button: HTMLButtonElement; menu: HTMLElement } {
  const button = el(
    "button",
    { type: "button", class: "button icon-only", popovertarget: "landmark-export", "aria-haspopup": "true", "aria-label": words.exportHint, title: words.exportHint },
    icon("download"),
  );
  const save = async ({ ending, type, made }: (typeof KINDS)[number]): Promise<void> => {
    menu.hidePopover();
    const writing = await import("./writing");
    const state = current();
    if (state?.scan) saveFile(fileName(state.scan, `landmarks.${ending}`), writing[made](state.picks.present, state.scan.info.unit, certainNames(state.picks.present, state.certain), onlyAgreed(state)), type);
  };
  const items = KINDS.map((kind) => el("button", { type: "button", class: "menu-item", onclick: () => void save(kind) }, el("span", {}, `landmarks.${kind.ending}`), el("span", { class: "muted small" }, kind.hint)));
  const menu = el("div", { class: "menu", id: "landmark-export", popover: "auto", role: "group", "aria-label": words.exportHint }, ...items);
  menu.addEventListener("toggle", () => {
    const { left, top, bottom } = button.getBoundingClientRect();
    const { width, height } = menu.getBoundingClientRect();
    const hasRoom = bottom + GAP + height < innerHeight;
    menu.style.inset = `${hasRoom ? bottom + GAP : top - GAP - height}px auto auto ${Math.max(GAP, Math.min(left, innerWidth - width - GAP))}px`;
  });
  return { button, menu };
}
