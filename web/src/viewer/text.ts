// The 3D view and its buttons.
import type { Look, Overlay, ViewName } from "./state";

export const view = {
  label: "View",
  names: { front: "Front", left: "Left", right: "Right", back: "Back", top: "Top" } satisfies Record<ViewName, string>,
  hints: {
    front: "From the front (F)",
    left: "From the patient's left",
    right: "From the patient's right",
    back: "From behind",
    top: "From above the head",
  } satisfies Record<ViewName, string>,
  overlayLabel: "What is shown",
  bar: "Tools and view",
  scale: (cm: number) => `${cm}\u00a0cm`,
  overlays: { scan: "Skin", both: "Both", model: "Model" } satisfies Record<Overlay, string>,
  overlayHints: {
    scan: "The scan alone",
    both: "The model over the scan",
    model: "The model alone",
  } satisfies Record<Overlay, string>,
  looks: { distances: "Distances", mirror: "Left on right", relief: "Folds darker", loose: "Table and loose pieces", colours: "The scan's own colours", linked: "Turn both together", slices: "Slices" } satisfies Record<Look, string>,
  lookHints: {
    distances: "The model coloured by its distance to the scan (D)",
    mirror: "The left breast mirrored onto the right one, coloured by the difference",
    relief: "Folds darker, what stands out brighter",
    loose: "All that was scanned; it cannot be drawn on, and stays in all files",
    colours: "As the camera saw them",
    linked: "Turning one pane turns the other",
    slices: "Axial, sagittal and coronal beside the body, with one cross",
  } satisfies Record<Look, string>,
  alone: { scan: "Scan", model: "Model" },
  left: "patient's left",
  right: "patient's right",
  canvas: "3D view of the scan. Arrow keys turn it, plus and minus zoom; while a landmark is wanted they move a cross, and Enter places it.",
  shared: "3D view of the result. Drag to turn it, scroll to zoom; the buttons below show it from all sides.",
};

export const errors = {
  noGraphics:
    "This browser offers no WebGL 2, so the body cannot be drawn. Turn on hardware acceleration or use another browser; the command line works without.",
  loadAgain: "Load the page again",
  graphicsLost: "The graphics driver dropped this page's picture. It comes back by itself in most cases; if not, load the page again.",
};
