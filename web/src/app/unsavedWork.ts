// A session that has ended leads to the sign-in page, and back to what the page showed.  What could not be saved waits in
// store/outbox.ts.
const KEY = "breastrig.after-sign-in";

type Memory = Pick<Storage, "getItem" | "setItem" | "removeItem">;

export const keepAddress = (hash: string, memory: Memory): void => memory.setItem(KEY, hash);

/** Once: it is forgotten as soon as it was asked for. */
export function takeAddress(memory: Memory): string | null {
  const hash = memory.getItem(KEY);
  memory.removeItem(KEY);
  return hash;
}
