// A session that has ended leads to the sign-in page.  What the page showed, and landmarks and lines that could not be
// saved any more, wait in this tab's memory and are taken up again afterwards.
import type { OwnLine } from "../drawing/lines/lines";
import { certainNames } from "../landmarks/certain";
import type { Picks } from "../landmarks/picks";
import type { Session } from "./session";

const KEY = "breastrig.after-sign-in";

export interface Waiting {
  readonly hash: string;
  readonly unsaved: { readonly scan: string; readonly picks?: Picks; readonly certain?: readonly string[]; readonly lines?: readonly OwnLine[] } | null;
}

type Memory = Pick<Storage, "getItem" | "setItem" | "removeItem">;

export function keepUnsaved(state: Session, hash: string, memory: Memory): void {
  const picks = state.saving === "saved" ? {} : { picks: state.picks.present, certain: certainNames(state.picks.present, state.certain) };
  const lines = state.drawn.saving === "saved" ? {} : { lines: state.drawn.lines.present };
  const isAll = state.saving === "saved" && state.drawn.saving === "saved";
  const unsaved = state.scan && !isAll ? { scan: state.scan.info.id, ...picks, ...lines } : null;
  memory.setItem(KEY, JSON.stringify({ hash, unsaved } satisfies Waiting));
}

/** Once: it is forgotten as soon as it was asked for. */
export function takeUnsaved(memory: Memory): Waiting | null {
  const kept = memory.getItem(KEY);
  memory.removeItem(KEY);
  try {
    return kept === null ? null : (JSON.parse(kept) as Waiting);
  } catch {
    return null;
  }
}
