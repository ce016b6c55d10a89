// What of the plan nobody has looked at yet, said before it is printed: each with the way there.
import { asksOf } from "../../checks/state";
import { wideOf } from "../../fit/fingers";
import { isUnusable } from "../../fit/state";
import { levelOf, linesOn } from "../../fit/verdict";
import { capital } from "../../languages/words";
import { inStance } from "../../scan/text";
import { isPredicted, otherState, stanceNames, stanceOf } from "../../stances/state";
import { foundInk, type NextShown } from "../nextStep";
import { handover as words } from "../text";

export interface Unchecked {
  readonly says: string;
  readonly isReady: boolean;
  readonly way: "check" | "points" | "plan" | "scan" | null; // null: nothing to do
  readonly isOther: boolean; // on the other scan
}

type Shown = NextShown & Parameters<typeof otherState>[0];

export function uncheckedOf(state: Shown): readonly Unchecked[] {
  const [mine, its] = stanceNames(state);
  const there = otherState(state) as Shown | null;
  const stance = (of: Shown, name: string, isOther: boolean): Unchecked[] => {
    const says = (sentence: string, way: Unchecked["way"], isReady = false): Unchecked => ({ says: `${capital(name)}: ${sentence}`, isReady, way, isOther });
    if (isPredicted(of)) return [says(words.predicted, "scan")];
    if (of.fit?.state !== "done") return [says(words.notFitted, "points")];
    if (isUnusable(of)) return [says(words.unusable, "points")];
    const { count } = asksOf(of);
    const isDoubtful = levelOf(of.fit.result) === "check";
    const lesions = of.drawn.onScan?.plan.lesions.filter(({ seen }) => !seen) ?? [];
    const missing = of.drawn.onScan?.plan.missing ?? [];
    return [
      says(count > 0 ? words.open(count) : isDoubtful ? words.doubtful(wideOf(linesOn(of)?.mm ?? null)) : words.ready, count > 0 ? "check" : null, count === 0 && !isDoubtful),
      ...missing.map(({ reason }) => says(/^.*?\.(?= |$)/.exec(reason)?.[0] ?? reason, "plan")),
      ...lesions.map((lesion) => says(words.unseen(lesion.name), "plan")),
    ];
  };
  const ink = foundInk({ ...state, step: "handover" });
  return [
    ...stance(state, mine, false),
    ...(there ? stance(there, isPredicted(there) ? inStance(stanceOf(there)) : its, true) : []),
    ...(ink?.kind === "ink" ? [{ says: words.ink(ink.count), isReady: false, way: "plan", isOther: ink.on !== null } as const] : []),
  ];
}
