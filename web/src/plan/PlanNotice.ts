// Says that somebody else has written the plan, and takes that over; asks which pattern or tumour stays where both were changed.
import { planChanges } from "../drawing/changes";
import { type DrawingSlice, stepOf } from "../drawing/state";
import type { FitSlice } from "../fit/state";
import type { PageSlice } from "../store/page";
import { only } from "../store/store";
import { button } from "../ui/controls";
import { el, setText, show } from "../ui/dom";
import type { Panel } from "../ui/Panel";
import type { PlanActions } from "./actions";
import * as text from "./text";

type Shown = Pick<PageSlice & FitSlice & DrawingSlice, "meta" | "drawing" | "drawn">;

export function createPlanNotice(plan: Pick<PlanActions, "takeOver" | "settle">): Panel<Shown> {
  const changed = el("div", { class: "notice-bar", role: "status", hidden: true }, el("p", {}, text.plan.changed), button(text.plan.takeOver, () => void plan.takeOver(), "outlined"));
  const differs = el("p", {});
  const contested = el("div", { class: "notice-bar", role: "status", hidden: true }, differs, button(text.plan.mine, () => plan.settle(false), "outlined"), button(text.plan.theirs, () => plan.settle(true), "outlined"));
  return {
    element: el("div", {}, changed, contested),
    select: only("meta", "drawing", "drawn"),
    update({ meta, drawing, drawn }: Shown): void {
      show(contested, drawn.contested !== null);
      show(changed, drawn.isChangedElsewhere && drawn.contested === null);
      if (!drawn.contested) return;
      const mine = stepOf({ drawing, drawn });
      setText(differs, text.plan.contested(planChanges(mine, { ...mine, ...drawn.contested }, [...(meta?.patterns ?? []), ...(meta?.drawings ?? [])])));
    },
  };
}
