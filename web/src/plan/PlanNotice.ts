// Says that somebody else has written the plan, and takes that over.
import type { DrawingSlice } from "../drawing/state";
import { only } from "../store/store";
import { button } from "../ui/controls";
import { el, show } from "../ui/dom";
import type { Panel } from "../ui/Panel";
import type { PlanActions } from "./actions";
import * as text from "./text";

export function createPlanNotice(plan: Pick<PlanActions, "takeOver">): Panel<Pick<DrawingSlice, "drawn">> {
  const element = el("div", { class: "notice-bar", role: "status", hidden: true }, el("p", {}, text.plan.changed), button(text.plan.takeOver, () => void plan.takeOver(), "outlined"));
  return {
    element,
    select: only("drawn"),
    update: ({ drawn }: Pick<DrawingSlice, "drawn">): void => show(element, drawn.isChangedElsewhere),
  };
}
