// What every panel is: an element, the parts of the state that it shows, and a way to bring it up to date with them.
import type { Store } from "../store/store";

export interface Panel<Shown extends object, State extends object = Shown> {
  readonly element: HTMLElement;
  /** Picks what it shows out of the state. */
  select(state: State): Shown;
  /** Called when something of that is another one. */
  update(shown: Shown): void;
}

/** From now on the panel shows what is in the store. */
export function follow<Shown extends object, State extends object>(store: Store<State>, panel: Panel<Shown, State>): void {
  store.select((state) => panel.select(state), (shown) => panel.update(shown));
}
