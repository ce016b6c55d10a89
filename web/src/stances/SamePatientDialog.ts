// Two scans that are filed as one patient's, and do not look like it: a person has to say, before anything is carried between them.
import type { FitSlice } from "../fit/state";
import type { ScanSlice } from "../scan/state";
import type { PageSlice } from "../store/page";
import { only } from "../store/store";
import { button, problem } from "../ui/controls";
import { el, setText } from "../ui/dom";
import type { Panel } from "../ui/Panel";
import type { StancesActions } from "./actions";
import { nameOfSecond, secondOf } from "./samePatient";
import type { StancesSlice } from "./state";
import { samePatient as words } from "./samePatientText";

type Shown = Pick<PageSlice & ScanSlice & FitSlice & StancesSlice, "problems" | "scan" | "stance" | "fit" | "stances">;

export function createSamePatientDialog(stances: Pick<StancesActions, "samePatient" | "dismiss">): Panel<Shown> {
  const says = el("p", {});
  const wrong = problem(() => stances.dismiss());
  const another = button("", () => void stances.samePatient(false), "primary");
  another.title = words.anotherHint;
  const same = button("", () => void stances.samePatient(true), "outlined");
  const element = el(
    "dialog",
    { class: "help ask", id: "same-patient-dialog", "aria-labelledby": "same-patient-title", oncancel: (event) => event.preventDefault() },
    el("h2", { id: "same-patient-title" }, words.title),
    says,
    wrong.element,
    el("div", { class: "toolbar" }, same, another),
  );
  return {
    element,
    select: only("problems", "scan", "stance", "fit", "stances"),
    update(state: Shown): void {
      const [asked] = state.stances.asked;
      const code = state.scan?.info.patient_code ?? "";
      if (asked) {
        setText(says, words.says(asked.says, code));
        setText(same, words.same(code));
        setText(another, words.another(nameOfSecond(state, secondOf(state, asked))));
      }
      wrong.set(state.problems.stances);
      if (asked && !element.open) element.showModal();
      if (!asked && element.open) element.close();
    },
  };
}
