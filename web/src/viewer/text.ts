// The 3D view and its buttons.
import type { Overlay, ViewName } from "./state";

export const view = {
  label: "View",
  names: { front: "Front", left: "Left", right: "Right", back: "Back", top: "Top" } satisfies Record<ViewName, string>,
  /** on the cube: the patient's sides */
  faces: { front: "Front", left: "L", right: "R", back: "Back", top: "Up" } satisfies Record<ViewName, string>,
  hints: {
    front: "From the front (F)",
    left: "From the patient's left",
    right: "From the patient's right",
    back: "From behind",
    top: "From above the head",
  } satisfies Record<ViewName, string>,
  overlayLabel: "Show",
  overlays: { scan: "Scan", both: "Both", model: "Model", beside: "Beside", swipe: "Swipe" } satisfies Record<Overlay, string>,
  overlayHints: {
    scan: "The scan alone",
    both: "The model over the scan",
    model: "The model alone",
    beside: "Scan and model side by side, turning together",
    swipe: "Scan to the left, model to the right of a line that you move",
  } satisfies Record<Overlay, string>,
  distances: "Distances",
  distancesHint: "Colour the model by its distance to the scan, in millimetres (D)",
  mirror: "Left on right",
  mirrorHint: "Left on right: the left breast mirrored onto the right one, coloured by the difference",
  relief: "Folds darker",
  reliefHint: "Folds darker, what stands out brighter: for a scan without colours",
  loose: "Table and loose pieces",
  looseHint: "Table, loose pieces and what was hidden: show all that was scanned; it cannot be drawn on, and stays in all files",
  swipe: "Line between scan and model",
  panes: { scan: "Scan", model: "Model" },
  canvas: "3D view of the scan. Arrow keys turn it, plus and minus zoom; while a landmark is wanted they move a cross, and Enter places it.",
  shared: "3D view of the result. Drag to turn it, scroll to zoom; the buttons below show it from all sides.",
  left: "patient's left",
  right: "patient's right",
};

export const errors = {
  noGraphics:
    "This browser offers no WebGL 2, so the body cannot be drawn. Turn on hardware acceleration or use another browser; the command line works without.",
  loadAgain: "Load the page again",
  graphicsLost: "The graphics driver dropped this page's picture. It comes back by itself in most cases; if not, load the page again.",
};
