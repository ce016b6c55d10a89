// The frame of the page: title, steps, top bar, the one button that says what comes next.
import type { Step, Theme } from "../store/page";
import { plural } from "../ui/plural";

export * from "./exportText";
export * from "./questionText";

export const page = {
  version: (version: string) => `version ${version}`,
  steps: { scan: "Scan", landmarks: "Landmarks", fit: "Fit", drawing: "Drawing", result: "Result" } satisfies Record<Step, string>,
  stepsLabel: "Steps",
};

export const top = {
  newScan: "New scan",
  code: "The patient's code",
  theme: (theme: Theme) => ({ system: "Theme: as the system", light: "Theme: light", dark: "Theme: dark" })[theme],
  share: "Share",
  signOut: "Sign out",
  help: "Keyboard and mouse",
};

export const next = {
  start: (label: string) => `Place ${label}`,
  armed: (label: string) => `Click on ${label}`,
  correct: "Look at the landmarks again",
  ink: (count: number, on: string | null) => `Look at the ${plural(count, "line", "lines")} found on the ${on === null ? "skin" : `${on} scan`}`,
  draw: "Draw",
  drawing: "Put the pen down",
  add: (stance: string) => `Add the ${stance} scan`,
  changeOver: (to: string) => `Go on with the ${to} scan`,
};
