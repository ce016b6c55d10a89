// Which scan of the page is sliced, what is drawn in its slices, and where the cross is.
import type { Frame, Vector } from "../../api/types";
import type { DrawingSlice } from "../../drawing/state";
import { laidPatterns } from "../../drawing/state";
import { lesionsOnScan, type LaidLesion } from "../../drawing/lesions/lesions";
import { LPS } from "../../drawing/slices/section";
import { areSlicesOpen } from "../../drawing/slices/state";
import type { FitSlice } from "../../fit/state";
import type { LandmarksSlice } from "../../landmarks/state";
import { isVolume, type ScanSlice, type ScanState } from "../../scan/state";
import type { PageSlice } from "../../store/page";
import { mmFrom, mmFromMetres } from "../../ui/units";
import { dot, leftOf } from "../../viewer/frame";
import { torsoOf } from "../cameras";
import { isComparing, isImage, scannedOther, type StancesSlice, type Workspace } from "../state";

export type SlicesShown = Pick<PageSlice & ScanSlice & LandmarksSlice & FitSlice & DrawingSlice & StancesSlice, "step" | "scan" | "picks" | "active" | "isCropping" | "isCanvasFull" | "stance" | "fit" | "drawn" | "lesion" | "slices" | "stances"> & { readonly checks: { readonly tour: object | null } };
type Sliced = Pick<Workspace, "scan" | "picks" | "fit" | "drawn">;

export interface SeenLesion {
  readonly id: string;
  readonly name: string;
  readonly center: Vector; // mm
  readonly radius: number;
  readonly reach: number | null; // mm: it lies within that nine times of ten; null where it was given here, or that is not known
  readonly isOwn: boolean; // given on this scan
  readonly laid: LaidLesion | null;
}

/** Slices stand on the stage; not while something is placed, checked, cut or drawn on the body alone. */
export const isSliced = (state: SlicesShown): boolean => areSlicesOpen(state) && state.active === null && state.checks.tour === null && state.step !== "points" && !state.isCropping && !state.isCanvasFull;

/** A lesion of the scan in work is moved or marked. */
const isInHand = ({ slices }: SlicesShown): boolean => slices.moves || slices.marks !== null;

/** The image where the page has one, in work or waiting; else, and while a lesion of the scan in work is moved, that scan. */
export function slicedOf(state: SlicesShown): { readonly of: Sliced; readonly isMain: boolean } {
  const other = scannedOther(state.stances);
  return other && isImage(other) && !isImage(state) && !isInHand(state) ? { of: other, isMain: false } : { of: state, isMain: true };
}

/** Whose 3D view stands beside the slices: where two scans are on the stage, the one that is not sliced. */
export const bodyBeside = (state: SlicesShown): "main" | "other" => (slicedOf(state).isMain && isComparing(state) ? "other" : "main");

/** An image's own axes, unless a person has turned it; else how the patient stands. */
export const frameOf = ({ info, frame, frameFrom }: ScanState): Frame => (isVolume(info) && frameFrom !== "person" ? LPS : frame);

export function lesionsIn({ drawn }: Pick<Sliced, "drawn">): SeenLesion[] {
  const unit = drawn.onScan?.plan.unit ?? "mm";
  const laid = new Map(lesionsOnScan(drawn.onScan?.plan ?? null).map((each) => [each.id, each]));
  const own = drawn.lesions.map(({ id, name, center, radius_mm: radius }): SeenLesion => ({ id, name, center, radius, reach: null, isOwn: true, laid: laid.get(id) ?? null }));
  const carried = [...laid.values()].filter(({ id }) => !own.some((each) => each.id === id));
  return [
    ...own,
    ...carried.map((each): SeenLesion => ({ id: each.id, name: each.name, center: each.center.map((value) => mmFrom(value, unit)) as unknown as Vector, radius: each.radius_mm, reach: each.error_mm ? each.radius_mm + each.error_mm : null, isOwn: false, laid: each })),
  ];
}

/** All planned lines on it, mm. */
export function linesIn({ drawn, fit }: Pick<Sliced, "drawn" | "fit">): (readonly Vector[])[] {
  const laid = [laidPatterns({ fit, drawn }), drawn.onScan?.carried ?? null].flatMap((each) => (each ? each.shapes.map(({ points, closed }) => ({ points: points.map((point) => point.map((value) => mmFrom(value, each.unit)) as unknown as Vector), closed })) : []));
  return [...drawn.lines.present, ...laid].map(({ points, closed }) => (closed && points.length > 0 ? [...points, points[0]!] : points));
}

/** Where the cross is: put there, else in the lesion that is looked at, or any; null where there is none. */
export function crossOf(state: SlicesShown, of: Sliced): Vector | null {
  const { cross } = state.slices;
  if (cross && cross.scan === of.scan?.info.id) return cross.at;
  const lesions = lesionsIn(of);
  const lesion = lesions.find(({ id }) => id === state.lesion) ?? lesions[0];
  return lesion?.center ?? null;
}

/** mm that the cross is left of the breastbone; null where no landmark says where that is. */
export function besideMiddle(at: Vector, of: Sliced, frame: Frame): number | null {
  const torso = torsoOf(of);
  if (!torso) return null;
  const [x, y, z] = [12, 13, 14].map((k) => mmFromMetres(torso.elements[k]!));
  const left = leftOf(frame);
  return dot(at, left) - dot([x!, y!, z!], left);
}

/** The same lesion where the body beside the slices has it, while the cross is in it; on the sliced scan's own body the cross itself. */
export function crossOnBody(state: SlicesShown, body: "main" | "other"): Vector | null {
  if (!isSliced(state) || bodyBeside(state) !== body) return null;
  const { of, isMain } = slicedOf(state);
  const at = crossOf(state, of);
  if (at === null || isMain === (body === "main")) return at;
  const here = lesionsIn(of).find(({ center, radius }) => Math.hypot(...center.map((value, k) => value - at[k]!)) < radius);
  const there = body === "main" ? state : state.stances.other;
  return (here && there && lesionsIn(there).find(({ id }) => id === here.id)?.center) ?? null;
}
