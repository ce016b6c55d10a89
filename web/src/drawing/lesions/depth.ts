// Where things stand on the depth ruler of a lesion, pixels: the skin to the left, the chest wall to the right.
import type { LaidLesion } from "./lesions";

export const WIDE = 264;
export const HIGH = 96;
const LEFT = 4; // of the skin, where nothing lies before it
const AIR_MM = 6; // behind the farthest thing
const HALF_WORDS = 56; // of the number with its band below the lesion
const BALL = { least: 4, most: 8 }; // the ball is no larger than its band is high

type Span = readonly [from: number, to: number];

export interface DepthPicture {
  readonly skin: number;
  readonly at: number; // of the centre
  readonly band: Span | null; // that holds the true depth with 90 %; null where it is not known
  readonly radius: number;
  readonly wall: number | null;
  readonly wallBand: Span | null;
  readonly isWallSeen: boolean; // in the scan's image; else the model's
  readonly words: number; // middle of the number
}

export function depthPicture({ distances, depth_mm: depth, radius_mm: radius }: Pick<LaidLesion, "distances" | "depth_mm" | "radius_mm">): DepthPicture {
  const [skin, chest] = (["skin", "chest_wall"] as const).map((wanted) => distances.find(({ kind }) => kind === wanted));
  const side = depth < 0 ? -1 : 1; // outside the skin it is drawn before it
  const spanOf = (from: number, each: typeof skin, sign: number): Span | null => {
    if (each?.low_mm == null || each.high_mm === null) return null;
    const [a, b] = [from + sign * each.low_mm, from + sign * each.high_mm];
    return [Math.min(a, b), Math.max(a, b)];
  };
  const band = spanOf(0, skin, side);
  const wall = chest ? depth + chest.mm : null;
  const wallBand = spanOf(depth, chest, 1);
  const least = Math.min(0, depth - radius, ...(band ?? []));
  const most = Math.max(depth + radius, ...(band ?? []), wall ?? 0, ...(wallBand ?? [])) + AIR_MM;
  const scale = (WIDE - LEFT) / (most - least);
  const x = (mm: number): number => LEFT + (mm - least) * scale;
  const span = (of: Span | null): Span | null => of && [x(of[0]), x(of[1])];
  return {
    skin: x(0),
    at: x(depth),
    band: span(band),
    radius: Math.min(Math.max(radius * scale, BALL.least), BALL.most),
    wall: wall === null ? null : x(wall),
    wallBand: span(wallBand),
    isWallSeen: chest?.seen === true,
    words: Math.min(Math.max(x(depth), HALF_WORDS), WIDE - HALF_WORDS),
  };
}
