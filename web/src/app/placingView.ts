// What is shown of scan and model by itself.  The body is the page: at rest the scan is seen alone and in its own colours, with what
// is drawn and marked on it; while a landmark or a line is placed all the more, as an areola cannot be found on grey, nor under the
// model.  While the model moves, settling, replayed or following a landmark, it is seen on the scan.  Afterwards what was
// shown before comes back, unless the person has chosen otherwise meanwhile.
import { handsOff, withoutCanvas } from "../drawing/state";
import { withoutLasso } from "../scan/state";
import type { Session } from "./session";

type Seen = Pick<Session, "active" | "drawn" | "fit" | "followed" | "overlay" | "overlayBefore" | "isCanvasFull" | "isCropping" | "step" | "scan" | "checks">;

const isMoving = ({ fit, followed }: Seen): boolean =>
  fit !== null && (fit.playing || (fit.shown >= 0 && fit.shown < fit.iterations.length - 1) || followed?.fit === fit.id);

const doing = (state: Seen): "placing" | "moving" | "rest" =>
  state.active !== null || state.checks.tour !== null || state.drawn.tool !== "none" ? "placing" : isMoving(state) ? "moving" : "rest";

/** For the store: what each change leads to. */
export function withPlacingView<State extends Seen>(changed: State, before: State): State {
  const state = withoutLasso(withoutCanvas(changed));
  if (state.active !== null && before.active === null && state.drawn.tool !== "none") return withPlacingView({ ...state, drawn: handsOff(state.drawn) }, before); // one thing in the hand
  if (before.overlayBefore !== null && state.overlay !== before.overlay) return { ...state, overlayBefore: null };
  const now = doing(state);
  if (now === doing(before)) return state;
  const chosen = state.overlayBefore ?? state.overlay;
  if (now === "placing") return { ...state, overlay: "scan", overlayBefore: chosen };
  if (now === "moving" && chosen === "scan") return { ...state, overlay: "both", overlayBefore: chosen };
  return { ...state, overlay: chosen, overlayBefore: null };
}
