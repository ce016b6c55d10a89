// What every panel is: an element, and a way to bring it up to date with the state.
import type { Session } from "../app/session";

export interface Panel {
  readonly element: HTMLElement;
  update(state: Session): void;
}
