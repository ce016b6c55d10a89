// Drawing without a pointer, while the view has the focus: arrows move a cross on the body and Enter is the click there;
// with a point chosen they move the point along the skin.
import type { Actions } from "../app/actions";
import type { Session } from "../app/session";
import type { Store } from "../store/store";
import { text } from "../ui/text";
import type { Crosshair } from "../viewer/Crosshair";
import { pickAt } from "../viewer/picking";
import type { ScanMesh } from "../scan/ScanMesh";
import type { Viewer } from "../viewer/Viewer";
import { cornerAt } from "./edits";
import { gap, lineNamed } from "./lines";

const ARROWS: Record<string, readonly [number, number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
const FAST = 5; // times as far with Shift
const CROSS_PX = 6;
const SAME_MM = 1; // Enter twice on one place ends the line

export function listenToPenKeys(canvas: HTMLElement, viewer: Viewer, scan: ScanMesh, cross: Crosshair, store: Store<Session>, { drawing, page }: Pick<Actions, "drawing" | "page">): void {
  function setCorner(): boolean {
    const { hit } = cross;
    if (!hit) return page.announce(text.landmarks.noSkin), true;
    const { drawn } = store.get();
    const last = lineNamed(drawn, drawn.open)?.points.at(-1) ?? drawn.start;
    if (drawn.tool === "tumour") drawing.tumour(hit.point);
    else if (last && gap(last, hit.point) < SAME_MM) drawing.finish();
    else drawing.click(hit.point);
    return true;
  }

  /** True when the key meant something here. */
  function press(key: string, far: number): boolean {
    const { step, drawn } = store.get();
    if (step !== "drawing" || drawn.tool === "none") return false;
    const arrow = ARROWS[key];
    const line = lineNamed(drawn, drawn.chosen);
    if (drawn.tool === "points") {
      if (!arrow || !line || drawn.corner === null) return false;
      const at = viewer.toPage(cornerAt(line, drawn.corner));
      const hit = pickAt(viewer, scan, at.x + far * arrow[0], at.y + far * arrow[1]);
      if (hit) drawing.moveCorner(line.name, drawn.corner, hit.point);
      return true;
    }
    if (key === "Enter") return cross.isShown && setCorner();
    if (!arrow) return false;
    const box = viewer.host.getBoundingClientRect();
    if (cross.isShown) cross.moveBy(far * CROSS_PX * arrow[0], far * CROSS_PX * arrow[1]);
    else cross.show(box.left + viewer.paneWidth / 2, box.top + box.height / 2);
    return true;
  }

  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || !press(event.key, event.shiftKey ? FAST : 1)) return;
    event.preventDefault();
    event.stopImmediatePropagation(); // the view's own keys would turn the body
  });
}
