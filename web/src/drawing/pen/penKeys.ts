// Drawing without a pointer, while the view has the focus: arrows move a cross on the body and Enter is the click there;
// with a point chosen they move the point along the skin.
import type { Vector } from "../../api/types";
import { landmarks as landmarkText } from "../../landmarks/text";
import type { PageSlice } from "../../store/page";
import type { Store } from "../../store/store";
import type { Crosshair } from "../../viewer/Crosshair";
import { ARROWS, onCanvasKey } from "../../viewer/keys";
import type { Surface } from "../../viewer/picking";
import type { Viewer } from "../../viewer/Viewer";
import type { DrawingActions } from "../actions";
import { cornerAt } from "../lines/edits";
import { gap } from "../lines/lines";
import { clickPen, skinAt } from "./penPlace";
import { type DrawingSlice, lineNamed } from "../state";

const CROSS_PX = 6;
const SAME_MM = 1; // Enter twice on one place ends the line

export function listenToPenKeys(canvas: HTMLElement, viewer: Viewer, scan: Surface, cross: Crosshair, store: Store<PageSlice & DrawingSlice>, drawing: DrawingActions): void {
  function setCorner(): boolean {
    const at = cross.place;
    const hit = at && skinAt(viewer, scan, drawing.skin(), at.x, at.y);
    if (!hit) return store.set({ announcement: landmarkText.noSkin }), true;
    const { drawn } = store.get();
    if (drawn.tool === "tape") return measure(hit), true;
    const last = lineNamed(drawn, drawn.open)?.points.at(-1) ?? drawn.start;
    if (drawn.tool === "tumour") drawing.tumour(hit);
    else if (last && gap(last, hit) < SAME_MM) drawing.finish();
    else clickPen(hit, drawn, drawing);
    return true;
  }

  function measure(hit: Vector): void {
    const { tape } = store.get().drawn;
    const last = tape?.isEnded ? undefined : tape?.places.at(-1);
    if (last && gap(last, hit) < SAME_MM) drawing.endTape();
    else drawing.measure(hit);
  }

  /** True when the key meant something here. */
  function press(key: string, far: number): boolean {
    const { step, drawn } = store.get();
    if (step !== "plan" || drawn.tool === "none") return false;
    const arrow = ARROWS[key];
    const line = lineNamed(drawn, drawn.chosen);
    if (drawn.tool === "points") {
      if (!arrow || !line || drawn.corner === null) return false;
      const at = viewer.toPage(cornerAt(line, drawn.corner));
      const hit = skinAt(viewer, scan, drawing.skin(), at.x + far * arrow[0], at.y + far * arrow[1]);
      if (hit) drawing.moveCorner(line.name, drawn.corner, hit);
      return true;
    }
    if (key === "Enter") return cross.isShown && setCorner();
    if (!arrow) return false;
    const box = viewer.host.getBoundingClientRect();
    if (cross.isShown) cross.moveBy(far * CROSS_PX * arrow[0], far * CROSS_PX * arrow[1]);
    else cross.show(box.left + box.width / 2, box.top + box.height / 2);
    return true;
  }

  onCanvasKey(canvas, press);
}
