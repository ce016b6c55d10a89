// Where the pen meets the patient, for the hand and for the keys: not on a table, not on what hangs loose, not on the
// inside of the back that shows through a hole.
import type { Vector } from "../../api/types";
import { pickAt, type Surface } from "../../viewer/picking";
import type { Viewer } from "../../viewer/Viewer";
import type { DrawingActions } from "../actions";
import type { Skin } from "../lines/skin";
import { type DrawnState, lineNamed } from "../state";
import { leadsOver } from "../lines/strokes";

/** The patient's skin under page pixels, mm; null beside it. */
export function skinAt(viewer: Viewer, scan: Surface, skin: Skin | null, clientX: number, clientY: number): Vector | null {
  const hit = pickAt(viewer, scan, clientX, clientY);
  return hit && (!skin || skin.mayDraw(hit, viewer.eye)) ? hit.point : null;
}

/** A click of the pen goes on with the open line only where skin leads there, or over a hole that is bridged. */
export function clickPen(at: Vector, drawn: DrawnState, drawing: DrawingActions): void {
  const skin = drawing.skin();
  const last = lineNamed(drawn, drawn.open)?.points.at(-1) ?? drawn.start;
  if (skin && last && !leadsOver(skin, last, at)) drawing.finish();
  drawing.click(at);
}
