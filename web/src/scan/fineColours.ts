// Whether a scan's colours show what is as fine as a pen's line.
import type { Scan } from "../api/types";

const FINE_MM = 1.5; // between coloured vertices; a pen's line falls between coarser ones, as the service says too

/** The scan has a texture, or coloured vertices so near to one another that a pen's line shows. */
export function mayShowInk({ colours, triangles, bounds_m: { min, max } }: Pick<Scan, "colours" | "triangles" | "bounds_m">): boolean {
  if (colours !== "vertex") return colours === "texture";
  const [w, h, d] = [0, 1, 2].map((axis) => 1000 * (max[axis]! - min[axis]!)) as [number, number, number];
  const skin = w * h + h * d + d * w; // half of the box around it: a body has about so much, seen from the front
  return Math.sqrt((2.3 * skin) / triangles) < FINE_MM;
}
