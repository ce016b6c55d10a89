// Lesions inside the body as values: a centre as people write it, and what the plan says of each on a scan.
import type { PlanLesion, PlanOnScan, Vector } from "../../api/types";
import { newId } from "../lines/lines";

export type LaidLesion = PlanOnScan["lesions"][number];
export type LesionDistance = LaidLesion["distances"][number];

/** Three numbers in mm, with spaces, commas or semicolons between; null for anything else. */
export function readCenter(written: string): Vector | null {
  const hasPoints = written.includes(".");
  const parts = written.trim().replace(/[()[\]]|mm/g, "").split(hasPoints ? /[\s,;]+/ : /[\s;]+|,\s+/).filter((part) => part !== "");
  const numbers = (parts.length === 1 ? parts[0]!.split(",") : parts).map((part) => (/^[-+]?(\d+([.,]\d*)?|[.,]\d+)$/.test(part) ? Number(part.replace(",", ".")) : NaN));
  return numbers.length === 3 && numbers.every(Number.isFinite) ? (numbers as unknown as Vector) : null;
}

/** A new lesion among those that are there. */
export const lesionAt = (name: string, center: Vector, radiusMm: number): PlanLesion => ({ kind: "lesion", id: newId(), scan: "", name, center: [...center], radius_mm: radiusMm });

export const RADIUS_MM = { least: 0.5, most: 80, usual: 5 }; // as the service takes it

/** By its centre and places on its edge, whose mean distance is its radius. */
export function markedBall([center, ...edge]: readonly Vector[]): { readonly center: Vector; readonly radius: number } {
  const far = edge.map((place) => Math.hypot(...place.map((value, k) => value - center![k]!)));
  return { center: center!, radius: far.reduce((sum, mm) => sum + mm, 0) / far.length };
}

/** Where each lies in the body of a scan, its own and those that were carried there. */
export const lesionsOnScan = (plan: PlanOnScan | null): PlanOnScan["lesions"] => plan?.lesions ?? [];

/** What is said of one: skin, nipple, and the line that is chosen, else the nearest of all. */
export function saidDistances({ distances }: LaidLesion, line: string | null): readonly LesionDistance[] {
  const lines = distances.filter(({ kind }) => kind === "line");
  return [...distances.filter(({ kind }) => kind !== "line"), ...(lines.filter(({ to }) => to === line).concat(lines).slice(0, 1))];
}
