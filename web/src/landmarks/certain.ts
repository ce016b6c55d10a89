// Picks that a person has said to be certain of: a fit follows them whatever all else says.
// Certain is a pick at its place.  One that is moved is judged again, and undo brings certainty back together with the place.
import type { Vector } from "../api/types";
import type { Picks } from "./picks";

/** Where each of them was when it was kept. */
export type Certain = Picks;

const ROUNDED_MM = 1e-6; // by another size and back; a nudge of one pixel is more

export const isSamePlace = (a: Vector | undefined, b: Vector | undefined): boolean =>
  a !== undefined && b !== undefined && a.every((value, axis) => Math.abs(value - b[axis]!) < ROUNDED_MM);

export const isCertain = (picks: Picks, certain: Certain, name: string): boolean => isSamePlace(picks[name], certain[name]);

/** The names that a landmark file and a fit are given. */
export const certainNames = (picks: Picks, certain: Certain): string[] => Object.keys(picks).filter((name) => isCertain(picks, certain, name));

/** These picks, where they are now. */
export const certainAt = (picks: Picks, names: readonly string[] = []): Certain =>
  Object.fromEntries(names.flatMap((name) => (picks[name] ? [[name, picks[name]]] : [])));
