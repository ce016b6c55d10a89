// A session that has ended leads to the sign-in page.  What the page showed, and landmarks that could not be saved any
// more, wait in this tab's memory and are taken up again afterwards.
import type { Picks } from "./landmarks";
import type { Session } from "./session";

const KEY = "breastrig.after-sign-in";

export interface Waiting {
  readonly hash: string;
  readonly unsaved: { readonly scan: string; readonly picks: Picks } | null;
}

type Memory = Pick<Storage, "getItem" | "setItem" | "removeItem">;

export function keepForLater(state: Session, hash: string, memory: Memory): void {
  const unsaved = state.scan && state.saving !== "saved" ? { scan: state.scan.info.id, picks: state.picks.present } : null;
  memory.setItem(KEY, JSON.stringify({ hash, unsaved } satisfies Waiting));
}

/** Once: it is forgotten as soon as it was asked for. */
export function takeUp(memory: Memory): Waiting | null {
  const kept = memory.getItem(KEY);
  memory.removeItem(KEY);
  try {
    return kept === null ? null : (JSON.parse(kept) as Waiting);
  } catch {
    return null;
  }
}
