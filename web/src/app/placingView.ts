// While a landmark or a line is placed the scan is seen alone and in its own colours: an areola cannot be found on grey, nor
// under the model.  Afterwards what was shown before comes back, unless the person has chosen otherwise meanwhile.
import { handsOff, withoutCanvas } from "../drawing/state";
import { withoutLasso } from "../scan/state";
import type { Session } from "./session";

type Seen = Pick<Session, "active" | "drawn" | "overlay" | "overlayBefore" | "isCanvasFull" | "isCropping" | "step" | "scan" | "checks">;

const isPlacing = ({ active, drawn, checks }: Seen): boolean => active !== null || checks.tour !== null || drawn.tool !== "none";

/** For the store: what each change leads to. */
export function withPlacingView<State extends Seen>(changed: State, before: State): State {
  const state = withoutLasso(withoutCanvas(changed));
  if (state.active !== null && before.active === null && state.drawn.tool !== "none") return withPlacingView({ ...state, drawn: handsOff(state.drawn) }, before); // one thing in the hand
  const [was, is] = [isPlacing(before), isPlacing(state)];
  if (is && !was) return { ...state, overlay: "scan", overlayBefore: before.overlay };
  if (was && state.overlay !== before.overlay) return { ...state, overlayBefore: null };
  if (was && !is && state.overlayBefore !== null) return { ...state, overlay: state.overlayBefore, overlayBefore: null };
  return state;
}
