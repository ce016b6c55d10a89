// The fitted model in words: size of each part and weight of each shape as sliders, grouped.  They pose the picture only.
import type { ModelSide, NodePose } from "../../api/types";
import type { PageSlice } from "../../store/page";
import { only } from "../../store/store";
import { button } from "../../ui/controls";
import { el, fill, setText, show } from "../../ui/dom";
import type { Panel } from "../../ui/Panel";
import { type Axis, scaleOf, weightOf } from "./handPose";
import type { HandPoseActions } from "./handPoseActions";
import { type FitSlice, isAtRest, isPosedByHand, modelOf, shownPoses } from "../state";
import * as text from "../text";

const words = text.handPose;
const STEP = 0.01;

interface Row {
  readonly element: HTMLElement;
  update(nodes: readonly NodePose[]): void;
}

type Shown = Pick<PageSlice & FitSlice, "meta" | "models" | "fit" | "handPose" | "followed">;

export function createShapeSliders(actions: HandPoseActions): Panel<Shown> {
  let rows: Row[] = [];
  const groups = el("div", { class: "slider-groups" });
  const note = el("p", { class: "look-here", hidden: true }, words.changed);
  const reset = button(words.reset, () => actions.reset(), "quiet outlined wide");
  const element = el("details", { class: "shape-sliders" }, el("summary", {}, words.title), el("p", { class: "muted small" }, words.what), note, reset, groups);
  let last: Shown | null = null;
  element.addEventListener("toggle", () => last && update(last));

  function update(state: Shown): void {
    last = state;
    const side = modelOf(state)?.side;
    const nodes = shownPoses(state);
    const isThere = Boolean(side && nodes && state.fit?.state === "done" && isAtRest(state.fit));
    show(element, isThere);
    if (!isThere || !element.open) return;
    show(note, isPosedByHand(state));
    reset.disabled = !isPosedByHand(state);
    fill(groups, side, () => {
      const made = groupsOf(side!, actions);
      rows = made.flatMap((group) => group.rows);
      return made.map((group) => el("details", {}, el("summary", {}, group.title), el("div", {}, ...group.rows.map((row) => row.element))));
    });
    for (const row of rows) row.update(nodes!);
  }

  return { element, select: only("meta", "models", "fit", "handPose", "followed"), update };
}

function groupsOf(side: ModelSide, actions: HandPoseActions): { title: string; rows: Row[] }[] {
  const sizes = side.bones.flatMap((bone) =>
    ([0, 1, 2] as Axis[]).map((axis) =>
      slider(
        `${words.bones[bone.name] ?? bone.name}, ${words.axes[axis]}`,
        [bone.scale_min[axis], bone.scale_max[axis]],
        words.scale,
        (nodes) => scaleOf(nodes, bone.name, axis),
        (value) => actions.scale(bone.name, axis, value),
      ),
    ),
  );
  const shapes = (isOne: (name: string) => boolean): Row[] =>
    side.shapes.flatMap((shape) => {
      const index = side.shape_names.indexOf(shape.name);
      if (index < 0 || !isOne(shape.name)) return [];
      const label = shape.label.replace(/^(left|right) /, "");
      const weigh = (value: number): void => actions.weigh(index, value);
      return [slider(label.charAt(0).toUpperCase() + label.slice(1), [shape.min, shape.max], words.weight, (nodes) => weightOf(nodes, index), weigh)];
    });
  return [
    { title: words.groups.left, rows: shapes((name) => name.endsWith("_L")) },
    { title: words.groups.right, rows: shapes((name) => name.endsWith("_R")) },
    { title: words.groups.trunk, rows: shapes((name) => !/_[LR]$/.test(name)) },
    { title: words.groups.size, rows: sizes },
  ];
}

function slider(name: string, [min, max]: readonly [number, number], format: (value: number) => string, read: (nodes: readonly NodePose[]) => number | null, moved: (value: number) => void): Row {
  const input = el("input", { type: "range", class: "slider", min, max, step: STEP, oninput: () => moved(Number(input.value)) });
  const value = el("span", { class: "slider-value" });
  const element = el("label", { class: "slider-row" }, el("span", {}, name), value, input);
  return {
    element,
    update(nodes) {
      const now = read(nodes) ?? 0;
      input.value = String(now);
      setText(value, format(now));
      input.setAttribute("aria-valuetext", format(now));
    },
  };
}
