// The running fit and its iterations.
import { plural } from "../ui/plural";

export * from "./resultText";

export const fit = {
  preset: "Settings",
  presets: { default: "Best known (default)", paper: "As in the paper" } as Record<string, string>,
  refine: "Follow the skin",
  refineHint: "After the fit the surface bends smoothly onto the skin that the scan shows; bones and shapes stay as fitted, and the model's own numbers stand beside.",
  cancel: "Cancel the fit",
  waiting: "Waiting for a free worker …",
  running: "Fitting …",
  stage: "Stage",
  retrying: "The connection to the service broke; trying again. The fit goes on meanwhile.",
  gone: "This fit is no longer there: its scan was deleted, in another tab or by somebody else.",
  cancelled: "Cancelled. The iterations so far can still be looked at.",
  noLandmarks: "Without landmarks the fit finds its start alone: best facing front.",
  fewLandmarks: (count: number) => `With only ${plural(count, "landmark", "landmarks")} the start is found from the scan alone.`,
  with: (count: number) => `Fit with ${plural(count, "landmark", "landmarks")}`,
  without: "Fit without landmarks",
  again: (count: number) => (count === 0 ? "Fit again without landmarks" : `Fit again with ${plural(count, "landmark", "landmarks")}`),
  announceStarted: "The fit has started.",
  announceStage: (stage: string) => `Stage ${stage}.`,
  announceDone: (mean: string) => `The fit is done: mean distance ${mean} millimetres.`,
};

export const timeline = {
  label: "Iteration",
  position: (shown: string, last: string) => `${shown} / ${last}`,
  mean: (mm: string) => `mean ${mm} mm`,
  replay: "Replay",
  play: "Play",
  pause: "Pause",
};

export const errors = {
  model: "The model cannot be drawn: the service sent a file that is not the expected rig.",
  surface: "The fitted surface cannot be drawn: the service sent a file that does not belong to this fit.",
};
