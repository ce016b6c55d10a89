// The whole state in one place: read it, replace parts of it, be told when it changed.
// Listeners run at once and in order; a listener must not set (state flows one way).

export interface Store<State extends object> {
  get(): State;
  set(change: Partial<State> | ((state: State) => Partial<State>)): void;
  /** Calls `listener` now and after each change; returns the way to stop that. */
  subscribe(listener: (state: State, before: State) => void): () => void;
}

export function createStore<State extends object>(initial: State): Store<State> {
  let state = initial;
  let telling = false;
  const listeners = new Set<(state: State, before: State) => void>();
  return {
    get: () => state,
    set(change) {
      if (telling) throw new Error("A listener of the store tried to change it.");
      const before = state;
      state = { ...state, ...(typeof change === "function" ? change(state) : change) };
      telling = true;
      try {
        for (const listener of listeners) listener(state, before);
      } finally {
        telling = false;
      }
    },
    subscribe(listener) {
      listeners.add(listener);
      listener(state, state);
      return () => listeners.delete(listener);
    },
  };
}
