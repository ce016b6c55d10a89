// The 3D view and its buttons.
import { word } from "../languages/words";
import type { Look, Overlay, ViewName } from "./state";

export const view = {
  label: word("viewer.view.label"),
  names: { front: word("viewer.view.names.front"), left: word("viewer.view.names.left"), right: word("viewer.view.names.right"), back: word("viewer.view.names.back"), top: word("viewer.view.names.top") } satisfies Record<ViewName, string>,
  hints: {
    front: word("viewer.view.hints.front"),
    left: word("viewer.view.hints.left"),
    right: word("viewer.view.hints.right"),
    back: word("viewer.view.hints.back"),
    top: word("viewer.view.hints.top"),
  } satisfies Record<ViewName, string>,
  overlayLabel: word("viewer.view.overlayLabel"),
  bar: word("viewer.view.bar"),
  scale: (cm: number) => word("viewer.view.scale", { cm }),
  overlays: { scan: word("viewer.view.overlays.scan"), both: word("viewer.view.overlays.both"), model: word("viewer.view.overlays.model") } satisfies Record<Overlay, string>,
  overlayHints: {
    scan: word("viewer.view.overlayHints.scan"),
    both: word("viewer.view.overlayHints.both"),
    model: word("viewer.view.overlayHints.model"),
  } satisfies Record<Overlay, string>,
  looks: { distances: word("viewer.view.looks.distances"), mirror: word("viewer.view.looks.mirror"), relief: word("viewer.view.looks.relief"), loose: word("viewer.view.looks.loose"), colours: word("viewer.view.looks.colours"), linked: word("viewer.view.looks.linked"), slices: word("viewer.view.looks.slices") } satisfies Record<Look, string>,
  lookHints: {
    distances: word("viewer.view.lookHints.distances"),
    mirror: word("viewer.view.lookHints.mirror"),
    relief: word("viewer.view.lookHints.relief"),
    loose: word("viewer.view.lookHints.loose"),
    colours: word("viewer.view.lookHints.colours"),
    linked: word("viewer.view.lookHints.linked"),
    slices: word("viewer.view.lookHints.slices"),
  } satisfies Record<Look, string>,
  alone: { scan: word("viewer.view.alone.scan"), model: word("viewer.view.alone.model") },
  left: word("viewer.view.left"),
  right: word("viewer.view.right"),
  canvas: word("viewer.view.canvas"),
  shared: word("viewer.view.shared"),
};

export const errors = {
  noGraphics:
    word("viewer.errors.noGraphics"),
  loadAgain: word("viewer.errors.loadAgain"),
  graphicsLost: word("viewer.errors.graphicsLost"),
};
