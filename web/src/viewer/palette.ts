// The colours of the 3D view.  They are CSS variables like all others, so that style.css alone decides the look.
import { Color } from "three";

const NAMES = ["canvas", "scan", "scan-edge", "clay", "line", "line-outline", "ruler"] as const;
export type Palette = Record<(typeof NAMES)[number], Color>;

export function readPalette(): Palette {
  const style = getComputedStyle(document.documentElement);
  const entries = NAMES.map((name) => [name, new Color(style.getPropertyValue(`--view-${name}`).trim())]);
  return Object.fromEntries(entries) as Palette;
}
