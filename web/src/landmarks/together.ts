// Picks of one scan that were changed here and meanwhile elsewhere: another tab, somebody else.
import type { Vector } from "../api/types";
import { certainAt, isSamePlace } from "./certain";
import type { Picks } from "./picks";

/** As the service keeps them: places, and the names of those that a fit follows whatever all else says. */
export interface KeptPicks {
  readonly picks: Picks;
  readonly certain: readonly string[];
}

export const NO_PICKS: KeptPicks = { picks: {}, certain: [] };

/** In a scan that is so many times as large. */
export const timesLarger = <Kept extends KeptPicks>(kept: Kept, factor: number): Kept =>
  factor === 1 ? kept : { ...kept, picks: Object.fromEntries(Object.entries(kept.picks).map(([name, place]) => [name, place.map((value) => factor * value) as unknown as Vector])) };

/** The same place, or none in either. */
const isSame = (a: Picks, b: Picks, name: string): boolean => (name in a ? isSamePlace(a[name], b[name]) : !(name in b));

const isSameAll = (a: KeptPicks, b: KeptPicks, name: string): boolean => isSame(a.picks, b.picks, name) && a.certain.includes(name) === b.certain.includes(name);

export interface Together extends KeptPicks {
  /** Landmarks that are as they were changed elsewhere. */
  readonly taken: readonly string[];
  /** Changed here and elsewhere: as they are here. */
  readonly overruled: readonly string[];
}

/** What both wanted: `mine` and `theirs` each began with `base`.  Of a landmark that both changed mine stays, for it is the later hand. */
export function together(base: KeptPicks, mine: KeptPicks, theirs: KeptPicks): Together {
  const names = [...new Set([...Object.keys(mine.picks), ...Object.keys(theirs.picks), ...Object.keys(base.picks)])];
  const theirOwn = names.filter((name) => !isSameAll(base, theirs, name) && !isSameAll(mine, theirs, name));
  const taken = theirOwn.filter((name) => isSameAll(base, mine, name));
  const from = (name: string): KeptPicks => (taken.includes(name) ? theirs : mine);
  const picks = Object.fromEntries(names.flatMap((name) => (from(name).picks[name] ? [[name, from(name).picks[name]!]] : [])));
  const certain = names.filter((name) => name in picks && from(name).certain.includes(name));
  return { picks, certain, taken, overruled: theirOwn.filter((name) => !taken.includes(name)) };
}

/** Picks of a step of the history with what was changed elsewhere, so that going back takes nothing of it away; themselves where that is nothing. */
export function withTheirs(picks: Picks, base: KeptPicks, theirs: KeptPicks): Picks {
  const both = together({ ...base, certain: [] }, { picks, certain: [] }, { ...theirs, certain: [] });
  return both.taken.length === 0 ? picks : both.picks;
}

/** Where each certain pick was kept, with what was said elsewhere. */
export function certainWith(certain: Picks, { picks, certain: names, taken }: Together): Picks {
  const rest = Object.entries(certain).filter(([name]) => !taken.includes(name));
  return { ...Object.fromEntries(rest), ...certainAt(picks, names.filter((name) => taken.includes(name))) };
}
