// The whole state in one place: read it, replace parts of it, follow its changes.
// Listeners run at once and in the order in which they came; a listener must not set (state flows one way).
//
// A store of a state with more parts serves wherever fewer are asked for: a feature names in its types the parts that it
// reads and writes, and is given the store of the whole page.

export interface Store<State extends object> {
  get(): State;
  set(change: Partial<State> | ((state: State) => Partial<State>)): void;
  /** Calls `listener` now and after each change; returns the way to stop that. */
  subscribe(listener: (state: State, before: State) => void): () => void;
  /** The same for some parts of the state: calls `listener` now, and when a value that `select` picks is another one. */
  select<Parts extends object>(select: (state: State) => Parts, listener: (now: Parts, before: Parts) => void): () => void;
}

/** `settle`: what follows from any change by itself, whoever made it; informed before all others. */
export function createStore<State extends object>(initial: State, settle: (state: State, before: State) => State = (state) => state): Store<State> {
  let state = initial;
  let isNotifying = false;
  const listeners = new Set<(state: State, before: State) => void>();

  function subscribe(listener: (state: State, before: State) => void): () => void {
    listeners.add(listener);
    listener(state, state);
    return () => listeners.delete(listener);
  }

  return {
    get: () => state,
    set(change) {
      if (isNotifying) throw new Error("A listener of the store tried to change it.");
      const before = state;
      state = settle({ ...state, ...(typeof change === "function" ? change(state) : change) }, before);
      isNotifying = true;
      try {
        for (const listener of listeners) listener(state, before);
      } finally {
        isNotifying = false;
      }
    },
    subscribe,
    select(select, listener) {
      let last: ReturnType<typeof select> | null = null;
      return subscribe((now) => {
        const parts = select(now);
        if (last !== null && isSame(parts, last)) return;
        const before = last ?? parts;
        last = parts;
        listener(parts, before);
      });
    },
  };
}

/** A selector that picks some parts as they are. */
export const only =
  <Key extends string>(...keys: readonly Key[]) =>
  <State extends Record<Key, unknown>>(state: State): Pick<State, Key> =>
    Object.fromEntries(keys.map((key) => [key, state[key]])) as Pick<State, Key>;

/** For a selector: the fields of a part, one by one, but those of which nothing is shown there. */
export const fieldsOf = <Name extends string, State extends Record<Name, object>>(state: State, name: Name, ...but: readonly (keyof State[Name] & string)[]): Readonly<Record<string, unknown>> =>
  Object.fromEntries(Object.entries(state[name]).flatMap(([key, value]) => ((but as readonly string[]).includes(key) ? [] : [[`${name}.${key}`, value]])));

/** Value by value, one level deep. */
function isSame<Parts extends object>(a: Parts, b: Parts): boolean {
  return (Object.keys({ ...a, ...b }) as (keyof Parts)[]).every((key) => Object.is(a[key], b[key]));
}
