// The running fit and its iterations.
import { word } from "../languages/words";

export * from "./resultText";

export const fit = {
  preset: word("fit.preset"),
  presets: { default: word("fit.presets.default"), paper: word("fit.presets.paper") } as Record<string, string>,
  refine: word("fit.refine"),
  refineHint: word("fit.refineHint"),
  cancel: word("fit.cancel"),
  waiting: word("fit.waiting"),
  running: word("fit.running"),
  stage: word("fit.stage"),
  retrying: word("fit.retrying"),
  gone: word("fit.gone"),
  cancelled: word("fit.cancelled"),
  noLandmarks: word("fit.noLandmarks"),
  fewLandmarks: (count: number) => word("fit.fewLandmarks", { count }),
  with: (count: number) => word("fit.with", { count }),
  without: word("fit.without"),
  again: (count: number) => (count === 0 ? word("fit.againWithout") : word("fit.again", { count })),
  announceStarted: word("fit.announceStarted"),
  announceStage: (stage: string) => word("fit.announceStage", { stage }),
  announceDone: (mean: string) => word("fit.announceDone", { mean }),
};

export const timeline = {
  label: word("fit.timeline.label"),
  position: (shown: string, last: string) => `${shown} / ${last}`,
  mean: (mm: string) => word("fit.timeline.mean", { mm }),
  replay: word("fit.timeline.replay"),
  play: word("fit.timeline.play"),
  pause: word("fit.timeline.pause"),
};

export const errors = {
  model: word("fit.errors.model"),
  surface: word("fit.errors.surface"),
};
