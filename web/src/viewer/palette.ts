// The colours of the 3D view.  They are CSS variables like all others, so that the style sheet alone decides the look.
import { Color } from "three";

const NAMES = ["canvas", "scan", "scan-edge", "clay", "ink", "ink-outline", "lesion", "ruler", "unknown"] as const;
export type Palette = Record<(typeof NAMES)[number], Color>;

/** Asks the browser what each variable comes to in the theme that holds. */
export function readPalette(): Palette {
  const probe = document.body.appendChild(document.createElement("span"));
  const entries = NAMES.map((name) => {
    probe.style.color = `var(--view-${name})`;
    return [name, new Color(getComputedStyle(probe).color)];
  });
  probe.remove();
  return Object.fromEntries(entries) as Palette;
}
