// In the top bar: which stance the page works on, the second one, both beside each other, their measures.
import type { FitSlice } from "../fit/state";
import type { LandmarksSlice } from "../landmarks/state";
import type { ScanSlice } from "../scan/state";
import { only } from "../store/store";
import { el, fill, setText, show } from "../ui/dom";
import type { Panel } from "../ui/Panel";
import type { StancesActions } from "./actions";
import { further, isComparing, isPredicted, stanceNames, type StancesSlice } from "./state";
import * as text from "./text";

const words = text.stances;

type Shown = Pick<ScanSlice & LandmarksSlice & FitSlice & StancesSlice, "scan" | "active" | "stance" | "fit" | "isStarting" | "stances">;

export function createStancesBar(stances: StancesActions): Panel<Shown> {
  let isSecond = false;
  let isMade = false; // the other one is predicted: it is looked at, never worked on
  const tab = (second: boolean): HTMLButtonElement => el("button", { type: "button", onclick: () => isSecond !== second && (isMade ? stances.compare(true) : void stances.swap()) });
  const tabs = [tab(false), tab(true)];
  const more = el("span", {}); // of the patient's further scans
  const both = el("div", { class: "segmented", role: "group", "aria-label": words.label }, ...tabs, more);
  const add = el("button", { type: "button", class: "button quiet outlined", title: words.addHint, id: "add-stance", "aria-label": words.add, onclick: () => stances.dialog(true) });
  let comparing = false;
  let linked = true;
  const compare = el("button", { type: "button", class: "button quiet outlined toggle-button", title: words.compareHint, id: "compare", onclick: () => stances.compare(!comparing) }, words.compare);
  const link = el("button", { type: "button", class: "button quiet outlined toggle-button", title: words.linkHint, id: "link-views", onclick: () => stances.link(!linked) }, words.link);
  const measures = el("button", { type: "button", class: "button quiet outlined", title: words.measuresHint, id: "measures", onclick: () => void stances.measures(true) }, words.measures);
  const element = el("div", { class: "stances-bar", hidden: true }, both, add, compare, link, measures);
  return {
    element,
    select: only("scan", "active", "stance", "fit", "isStarting", "stances"),
    update(state: Shown): void {
      const { other, isLinked } = state.stances;
      show(element, state.scan !== null);
      const others = further(state.stances);
      show(both, other !== null || others.length > 0);
      isMade = other !== null && isPredicted(other);
      const isAlone = other === null && others.length === 0;
      fill(add, isAlone, () => (isAlone ? [words.add] : ["+"]));
      fill(more, [others, state.isStarting], () =>
        others.map((scan) => el("button", { type: "button", title: words.working(scan.stance), disabled: state.isStarting, "aria-pressed": "false", onclick: () => void stances.third(scan) }, words.name(scan.stance))),
      );
      show(compare, other !== null);
      isSecond = state.stances.isSecond;
      comparing = state.stances.isComparing;
      linked = isLinked;
      show(link, isComparing(state));
      compare.setAttribute("aria-pressed", String(isComparing(state)));
      link.setAttribute("aria-pressed", String(isLinked));
      show(measures, state.fit?.state === "done");
      show(tabs[1]!, other !== null);
      const [mine, its] = stanceNames(state);
      const inOrder = isSecond ? [its, mine] : [mine, its];
      tabs.forEach((each, i) => {
        setText(each, words.name(inOrder[i]!));
        each.title = isMade && (i === 1) !== isSecond ? words.predicted.show(inOrder[i]!) : words.working(inOrder[i]!);
        each.disabled = state.isStarting;
        each.setAttribute("aria-pressed", String((i === 1) === isSecond));
      });
    },
  };
}
