// The signed distance of each model vertex to the scan (distances.bin) and the scale that shows it.
// The scale never adapts to the fit: the same colour means the same millimetres for every patient.

/** Millimetres at the ends of the scale; what lies beyond has the end's colour. */
export const SCALE_MM = 5;
/** Millimetres that a depth camera's own noise may explain: no colour is spent on them. */
export const SCANNER_MM = 2;

/** float32, little-endian, mm; NaN where the scan shows no skin, above zero where the model lies outside of it. */
export function readDistances(bytes: ArrayBuffer): Float32Array {
  if (bytes.byteLength % 4 !== 0) throw new Error("distances.bin holds no whole numbers");
  const view = new DataView(bytes);
  return Float32Array.from({ length: bytes.byteLength / 4 }, (_, i) => view.getFloat32(4 * i, true));
}

export interface DistanceSummary {
  /** of the vertices that the scan shows: share within the scanner's error, beyond the scale, and the signed mean */
  readonly within: number;
  readonly beyond: number;
  readonly meanMm: number;
}

export function summarise(distances: Float32Array): DistanceSummary | null {
  const known = distances.filter((value) => !Number.isNaN(value));
  if (known.length === 0) return null;
  const share = (isCounted: (value: number) => boolean): number => known.filter(isCounted).length / known.length;
  return {
    within: share((value) => Math.abs(value) <= SCANNER_MM),
    beyond: share((value) => Math.abs(value) > SCALE_MM),
    meanMm: known.reduce((sum, value) => sum + value, 0) / known.length,
  };
}

/** Inside a triangle, from its corners; null when the scan shows no skin at one of them. */
export function distanceWithin(distances: Float32Array, corners: readonly number[], weights: readonly number[]): number | null {
  const value = corners.reduce((sum, corner, i) => sum + weights[i]! * distances[corner]!, 0);
  return Number.isNaN(value) ? null : value;
}

/** One row for each vertex, in the order of fitted.ply; empty where the scan shows no skin. */
export function distancesCsv(distances: Float32Array): string {
  const rows = Array.from(distances, (mm, vertex) => `${vertex},${Number.isNaN(mm) ? "" : mm.toFixed(3)}`);
  return ["vertex,distance_mm", ...rows, ""].join("\r\n");
}

type Oklab = readonly [lightness: number, a: number, b: number];
// Blue under, orange over: distinguishable with any kind of colour blindness, and equally far from the neutral middle.
const INSIDE: Oklab = [0.47, -0.035, -0.155];
const MIDDLE: Oklab = [0.93, 0.002, 0.008];
const OUTSIDE: Oklab = [0.55, 0.105, 0.115];

function linearRgb([lightness, a, b]: Oklab): [number, number, number] {
  const l = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (lightness - 0.0894841775 * a - 1.291485548 * b) ** 3;
  const rgb = [
    4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
    -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
    -0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s,
  ];
  return rgb.map((value) => Math.min(1, Math.max(0, value))) as [number, number, number];
}

/** Linear RGB, 0 to 1.  Flat within the scanner's error, then even steps of lightness and hue (OKLab) to the ends. */
export function colourOf(mm: number): [number, number, number] {
  const share = Math.min(1, Math.max(0, (Math.abs(mm) - SCANNER_MM) / (SCALE_MM - SCANNER_MM)));
  const strength = Math.abs(mm) <= SCANNER_MM ? 0 : 0.18 + 0.82 * share; // a step at the band's edge: it is a limit
  const end = mm < 0 ? INSIDE : OUTSIDE;
  return linearRgb(MIDDLE.map((value, i) => value + strength * (end[i]! - value)) as unknown as Oklab);
}

const encode = (value: number): number => Math.round(255 * (value <= 0.0031308 ? 12.92 * value : 1.055 * value ** (1 / 2.4) - 0.055));

/** sRGB, 0 to 255, for the colour bar. */
export const screenColourOf = (mm: number): [number, number, number] => colourOf(mm).map(encode) as [number, number, number];
