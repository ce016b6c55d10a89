// Undo and redo as plain values: a history is three lists, and each operation returns a new one.

export interface History<Value, Step = Value> {
  readonly past: readonly Step[];
  readonly present: Value;
  readonly future: readonly Step[];
}

const KEPT = 200; // steps; far more than anybody undoes, and each is twelve points

export const startHistory = <Value, Step = Value>(present: Value): History<Value, Step> => ({ past: [], present, future: [] });

export function record<Value>(history: History<Value>, next: Value): History<Value> {
  return { past: [...history.past, history.present].slice(-KEPT), present: next, future: [] };
}

export function undo<Value>(history: History<Value>): History<Value> {
  const previous = history.past.at(-1);
  if (history.past.length === 0 || previous === undefined) return history;
  return { past: history.past.slice(0, -1), present: previous, future: [history.present, ...history.future] };
}

export function redo<Value>(history: History<Value>): History<Value> {
  const next = history.future[0];
  if (next === undefined) return history;
  return { past: [...history.past, history.present], present: next, future: history.future.slice(1) };
}
