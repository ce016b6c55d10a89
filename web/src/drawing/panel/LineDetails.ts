// The chosen line that a hand has drawn: its name, what can be done with it, and its points without a pointer.
import { button, iconButton } from "../../ui/controls";
import { el, fill, setText, show } from "../../ui/dom";
import { numberField } from "../../ui/NumberField";
import type { DrawingActions } from "../actions";
import { type OwnLine } from "../lines/lines";
import type { DrawnState } from "../state";
import { drawing as words } from "../text";

export function createLineDetails(drawing: DrawingActions) {
  const body = el("div", { class: "panel" });
  let chosen = "";
  const depth = numberField({ name: "line_depth", label: words.depth, unit: "mm", min: 1, max: 150, hint: words.depthHint, mayBeEmpty: true, changed: (mm) => drawing.cutTo(chosen, mm) });
  const corners = createCorners(drawing);
  function made({ name, closed }: OwnLine, mayMirror: boolean): HTMLElement[] {
    const field = el("input", {
      type: "text",
      class: "line-name",
      value: name,
      maxlength: 100,
      "aria-label": words.name(name),
      onchange: () => {
        const isTaken = !drawing.rename(name, field.value);
        field.setCustomValidity(isTaken && field.value.trim() !== "" ? words.nameTaken : "");
        if (isTaken && !field.reportValidity()) return;
        if (isTaken) field.value = name;
      },
      oninput: () => field.setCustomValidity(""),
    });
    const close = button(closed ? words.openShort : words.closeShort, () => drawing.close(name), "quiet outlined");
    close.setAttribute("aria-label", closed ? words.open(name) : words.close(name));
    return [field, el("div", { class: "buttons-row" }, close, mayMirror ? iconButton("mirror", words.mirror(name), () => drawing.mirror(name)) : null, el("span", { class: "spring" }), iconButton("eraser", words.erase(name), () => drawing.erase(name)))];
  }
  return {
    element: el("div", { class: "panel" }, body, depth.element, corners.element),
    update(line: OwnLine, mayMirror: boolean, drawn: DrawnState): void {
      if (chosen !== line.name) depth.drop();
      chosen = line.name;
      show(depth.element, line.closed);
      depth.set(line.depthMm ?? null);
      fill(body, [line.name, line.closed, mayMirror], () => made(line, mayMirror));
      corners.update(line, drawn);
    },
  };
}

/** One point after the other, moved by arrow keys, deleted. */
function createCorners(drawing: DrawingActions) {
  let now: { readonly line: OwnLine; readonly corner: number | null } | null = null;
  const where = el("span", { class: "small" });
  function step(by: number): void {
    if (!now) return;
    const count = now.line.corners.length;
    drawing.chooseCorner(now.corner === null ? (by > 0 ? 0 : count - 1) : (now.corner + by + count) % count);
    document.querySelector<HTMLElement>("canvas.view")?.scrollIntoView({ block: "nearest" });
  }
  const remove = button(words.remove, () => drawing.removeCorner(), "quiet outlined");
  const nudge = el("div", { class: "nudge", role: "group", "aria-label": words.nudge });
  for (const [key, label] of Object.entries(words.arrows)) {
    nudge.append(
      el("button", { type: "button", class: "button icon-only", "aria-label": label, title: label, onclick: () => document.querySelector("canvas.view")?.dispatchEvent(new KeyboardEvent("keydown", { key })) }, words.arrowSigns[key as keyof typeof words.arrowSigns]),
    );
  }
  const row = el("div", { class: "corner-row" }, iconButton("back", words.previous, () => step(-1)), where, iconButton("on", words.next, () => step(1)), el("span", { class: "spring" }), remove);
  const element = el("div", { class: "corners", hidden: true }, row, nudge);
  return {
    element,
    update(line: OwnLine, { tool, corner }: DrawnState): void {
      now = { line, corner };
      show(element, tool === "points");
      setText(where, corner === null ? words.noCorner(line.corners.length) : words.corner(corner + 1, line.corners.length));
      remove.disabled = corner === null;
      show(nudge, corner !== null);
    },
  };
}
