// Asks before a scan is deleted and says what goes with it.
import { drawingLabels, readRequest, TUMOUR } from "../../fit/requestedDrawing";
import { pickCount } from "../../landmarks/state";
import { scannedOther } from "../../stances/state";
import { only } from "../../store/store";
import { button } from "../../ui/controls";
import { el, setText, show } from "../../ui/dom";
import type { Panel } from "../../ui/Panel";
import type { DeletionActions } from "./actions";
import type { Session } from "../session";
import * as text from "../text";

const words = text.deletion;

type Shown = Pick<Session, "isAskingToDelete" | "scan" | "picks" | "drawn" | "drawing" | "fit" | "meta" | "stances">;

/** Patterns, tumour and note that were planned on the scan; a drawing of the model is nobody's work. */
function planned({ drawing, drawn, meta }: Shown): string[] {
  const { base, tumour } = readRequest(drawing);
  const labels = drawingLabels({ meta });
  const names = [...(meta?.patterns ?? []).filter(({ name }) => name === base), ...(tumour ? [{ name: TUMOUR }] : [])];
  return [...names.map(({ name }) => labels.get(name) ?? name), ...(drawn.note === "" ? [] : [words.note])];
}

export function createDeleteDialog(actions: DeletionActions): Panel<Shown> {
  const goes = el("p", {});
  const other = el("p", {});
  const keep = (): void => actions.ask(false);
  const element = el(
    "dialog",
    { class: "help ask", id: "delete-dialog", "aria-labelledby": "delete-title" },
    el("h2", { id: "delete-title" }, words.title),
    goes,
    other,
    el("p", { class: "muted" }, words.noWay),
    el("div", { class: "answers" }, button(words.keep, keep, "quiet outlined"), button(words.confirm, () => void actions.confirm(), "primary danger")),
  );
  element.addEventListener("cancel", (event) => {
    event.preventDefault();
    keep();
  });
  return {
    element,
    select: only("isAskingToDelete", "scan", "picks", "drawn", "drawing", "fit", "meta", "stances"),
    update(state: Shown): void {
      const isOpen = state.isAskingToDelete && state.scan !== null;
      if (isOpen) {
        const [lines, plans] = [state.drawn.lines.present.length, planned(state)];
        setText(goes, words.goes(pickCount(state), lines, plans, state.fit !== null));
        setText(other, words.other(lines + plans.length > 0));
      }
      show(other, scannedOther(state.stances) !== null);
      if (isOpen && !element.open) element.showModal();
      if (!isOpen && element.open) element.close();
    },
  };
}
