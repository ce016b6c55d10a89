// What the second screen shows, and how it was brought to scale.
import type { PlannedShape, Vector } from "../api/types";
import type { Place, Side } from "./camera";
import { projectionThrough, type Projection, type Refusal, type Sighting } from "./dlt";

export const CARD_MM = 85.6; // ISO/IEC 7810 ID-1: every bank card

/** Landmarks that are easy to find on a person and lie far apart come first. */
export const ORDER = ["suprasternal_notch", "nipple_L", "nipple_R", "acromion_L", "acromion_R", "umbilicus", "xiphoid", "inframammary_fold_L", "inframammary_fold_R", "midclavicle_L", "midclavicle_R", "mid_sternum"];

export interface Landmark {
  readonly name: string;
  readonly label: string;
  readonly point: Vector; // mm, scan's axes
}

/** Lines of the plan, mm in the scan's own axes. */
export type PlannedLine = Pick<PlannedShape, "name" | "closed" | "color" | "bridged"> & { readonly points: readonly Vector[] };

export interface ProjectorState {
  readonly mode: "scale" | "projector";
  readonly landmarks: readonly Landmark[]; // in the order in which they are asked for
  readonly lines: readonly PlannedLine[] | null; // null: not read yet
  readonly pixelsPerMm: number | null; // of this screen at this zoom; null: not measured
  readonly barPixels: number;
  readonly side: Side;
  readonly moved: Place; // pixels, of the picture at true scale
  readonly clicks: Readonly<Record<string, Place>>; // by landmark
  readonly wanted: string | null; // the landmark that the next click is
  readonly areToolsHidden: boolean;
  readonly hasOutline: boolean;
  readonly hasColours: boolean;
  readonly problem: string | null;
}

export const initialProjector: ProjectorState = {
  mode: "scale",
  landmarks: [],
  lines: null,
  pixelsPerMm: null,
  barPixels: 340,
  side: "front",
  moved: [0, 0],
  clicks: {},
  wanted: null,
  areToolsHidden: false,
  hasOutline: true,
  hasColours: true,
  problem: null,
};

export const sightingsOf = ({ landmarks, clicks }: Pick<ProjectorState, "landmarks" | "clicks">): { readonly name: string; readonly sighting: Sighting }[] =>
  landmarks.flatMap(({ name, point }) => (clicks[name] ? [{ name, sighting: { point, at: clicks[name] } }] : []));

export const projectionOf = (state: Pick<ProjectorState, "landmarks" | "clicks">): Projection | Refusal => projectionThrough(sightingsOf(state).map(({ sighting }) => sighting));

/** The first after `name` that has no place yet, round to the beginning; null when all have one. */
export function nextWanted({ landmarks, clicks }: Pick<ProjectorState, "landmarks" | "clicks">, name: string | null): string | null {
  const names = landmarks.map((landmark) => landmark.name);
  const start = name === null ? 0 : names.indexOf(name) + 1;
  return [...names.slice(start), ...names.slice(0, start)].find((each) => !clicks[each]) ?? null;
}

/** A click in the picture: the wanted landmark's place, and on to the next. */
export function withClick(state: ProjectorState, at: Place): Partial<ProjectorState> {
  if (state.wanted === null) return {};
  const clicks = { ...state.clicks, [state.wanted]: at };
  return { clicks, wanted: nextWanted({ landmarks: state.landmarks, clicks }, state.wanted) };
}

export function withoutClick(state: ProjectorState, name: string): Partial<ProjectorState> {
  const { [name]: _gone, ...clicks } = state.clicks;
  return { clicks, wanted: name };
}

/** What is remembered of a screen: it holds for its size and for one zoom. */
export const screenKey = ({ width, height }: { readonly width: number; readonly height: number }, zoom: number): string => `breastrig.screen.${width}x${height}@${zoom}`;

/** The places that were clicked for a fit, which hold for the same screen as long as the projector stands. */
export const clicksKey = (fit: string, screen: string): string => `${screen}.${fit}`;

/** Those of a landmark of this fit; none where nothing can be read. */
export function keptClicks(kept: string | null, landmarks: readonly Landmark[]): ProjectorState["clicks"] {
  try {
    const found = (JSON.parse(kept ?? "{}") ?? {}) as Record<string, unknown>;
    const isPlace = (place: unknown): place is Place => Array.isArray(place) && place.length === 2 && place.every(Number.isFinite);
    return Object.fromEntries(landmarks.flatMap(({ name }) => (isPlace(found[name]) ? [[name, found[name]]] : [])));
  } catch {
    return {};
  }
}

/** Of a colour that is too dark on black: the same hue, lighter. */
export function onBlack(color: string): string {
  const [r, g, b] = [1, 3, 5].map((at) => parseInt(color.slice(at, at + 2), 16) / 255) as [number, number, number];
  const [most, least] = [Math.max(r, g, b), Math.min(r, g, b)];
  if (most - least < 0.08) return "#ffffff"; // black, grey and white
  const LIGHT = 0.55; // of the darkest channel: bright enough beside white lines
  const lift = (value: number): number => Math.round(255 * (LIGHT * (1 - (value - least) / (most - least)) * 0.6 + ((value - least) / (most - least))));
  return `#${[r, g, b].map((value) => lift(value).toString(16).padStart(2, "0")).join("")}`;
}
