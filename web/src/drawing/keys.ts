// Keys of the step "drawing"; they go before the page's own.
import type { ScanSlice } from "../scan/state";
import type { PageSlice } from "../store/page";
import type { DrawingActions } from "./actions";
import type { DrawingSlice } from "./state";

/** Does what the key stands for; false leaves it to the page. */
export function drawingKey(state: Pick<PageSlice & ScanSlice & DrawingSlice, "step" | "scan" | "drawn" | "isCanvasFull">, event: KeyboardEvent, drawing: DrawingActions): boolean {
  const { drawn } = state;
  if (state.step !== "plan" || !state.scan) return false;
  const key = event.key.toLowerCase();
  if (key === "z") return (event.shiftKey ? drawing.redo() : drawing.undo()), true;
  if (key === "y") return drawing.redo(), true;
  if (event.ctrlKey || event.metaKey) return false;
  if (key === "p") return drawing.take(drawn.tool === "pen" ? "none" : "pen"), true;
  if (key === "e") return drawing.take(drawn.tool === "points" ? "none" : "points"), true;
  if (key === "t") return drawing.take(drawn.tool === "tumour" ? "none" : "tumour"), true;
  if (key === "m") return drawing.take(drawn.tool === "tape" ? "none" : "tape"), true;
  const isMeasuring = drawn.tool === "tape" && drawn.tape !== null && !drawn.tape.isEnded;
  if (key === "enter" && isMeasuring && isFree(event)) return drawing.endTape(), true;
  if (key === "enter" && drawn.tool === "pen" && (drawn.open || drawn.start) && isFree(event)) return drawing.finish(), true;
  if (key === "escape") {
    if (isMeasuring) drawing.endTape();
    else if (drawn.open || drawn.start) drawing.finish();
    else if (drawn.corner !== null) drawing.chooseCorner(null);
    else if (state.isCanvasFull) drawing.fullCanvas(false);
    else drawing.take("none");
    return true;
  }
  if ((key === "delete" || key === "backspace") && drawn.chosen !== null && drawn.tool === "points") {
    if (drawn.corner !== null) drawing.removeCorner();
    else drawing.erase(drawn.chosen);
    return true;
  }
  return false;
}

/** Enter presses the button that has the focus. */
const isFree = (event: KeyboardEvent): boolean => !(event.target instanceof HTMLElement && event.target.closest("button, a, label, summary"));
