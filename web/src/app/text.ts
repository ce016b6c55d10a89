// The frame of the page: title, steps, top bar, the one button that says what comes next.
import type { Step, Theme } from "./session";

export const page = {
  name: "BreastRig",
  notice: "Research use only. Not a medical device.",
  noticeLong:
    "Research use only. Not a medical device; not for diagnosis, treatment or surgical decisions. " +
    "Measurements carry scanner and fitting error.",
  version: (version: string) => `version ${version}`,
  steps: { scan: "Scan", landmarks: "Landmarks", fit: "Fit", drawing: "Drawing", result: "Result" } satisfies Record<Step, string>,
  stepsLabel: "Steps",
  dismiss: "Dismiss",
  close: "Close",
};

export const top = {
  newScan: "New scan",
  theme: (theme: Theme) => ({ system: "Theme: as the system", light: "Theme: light", dark: "Theme: dark" })[theme],
  share: "Share",
  signOut: "Sign out",
  help: "Keyboard and mouse",
  uploaded: "Uploaded scan",
};

export const next = {
  start: (label: string) => `Place ${label}`,
  armed: (label: string) => `Click on ${label}`,
};
