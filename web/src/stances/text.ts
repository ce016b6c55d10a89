// Two stances of one patient: the second scan, the two panes, the drawing in both, the table of measures.
import { plural } from "../ui/plural";

const capital = (word: string): string => word.charAt(0).toUpperCase() + word.slice(1);

export const strip = {
  label: "Scans",
  today: "Today",
  name: capital,
  image: "MRI",
  predicted: "Predicted",
  lines: (wide: string) => `lines ${wide}`,
  points: (count: number) => `${plural(count, "point", "points")} to check`,
  pane: (pane: number) => `in pane ${pane}`,
  add: "+ Scan",
  addHint: "Another scan of this patient: standing, supine, prone, or the label map of an MRI",
};

export const stances = {
  here: (name: string) => capital(name),
  called: (stance: string, isPredicted: boolean) => (isPredicted ? `${stance}, predicted` : stance),
  work: "A tap or Enter: work on it.",
  following: "following …",
  canvas: (name: string) => `3D view of the ${name} scan. Drag to turn it, scroll to zoom.`,

  predicted: {
    badge: (isSimulated: boolean) => (isSimulated ? "simulated, not scanned" : "predicted, not scanned"),
    picture: (name: string) => `${name}, not scanned`,
    sure: (lines: string, wide: string) => `${lines.charAt(0).toUpperCase()}${lines.slice(1)} are ${wide}.`,
    offer: "If you have no such scan",
    offerWhat: "Predicted from this scan, with error bands. Nothing can be drawn on it. A scan replaces it.",
    predict: (stance: string) => `Predict ${stance}`,
    needsFit: "Fit this scan first. The prediction starts from its fit.",
    busy: (stance: string) => `Predicting ${stance} …`,
    gone: "This prediction is no longer there: its scan was deleted, in another tab or by somebody else.",
    announce: (stance: string) => `The ${stance} body is predicted and stands beside the scan.`,
  },

  dialog: {
    title: "Add a scan of this patient",
    what: "Another position or another day. What is planned is then shown on all scans of the patient.",
    upload: "Choose a scan file",
    examples: "Example patient",
    elsewhere: "Filed under another code",
    code: "Code of the other patient",
    find: "Show its scans",
    nobody: (code: string) => `No other patient here has the code “${code}”; type it as it is in the list.`,
    moves: (code: string, there: string) => `Choose one of ${there} only if it shows patient ${code}: it is then filed under ${code}.`,
    at: (stance: string, when: string) => `${capital(stance)}, ${when}`,
    busy: "Loading the scan …",
  },

  carry: {
    title: "On the other scan",
    needsFits: (names: string) => `The plan is transferred between two fitted scans. Not fitted yet: ${names}.`,
    needsLines: "Draw a line or choose a pattern on either scan. It is then shown on both.",
    others: "the patient's other scans",
    busy: "Transferring the plan …",
    done: (names: readonly string[]) => `The plan is shown on the ${names.join(" and the ")} scan and follows every change.`,
    donePredicted: (name: string) => `The plan is shown on the ${name} body and follows every change. This body is predicted, not scanned.`,
    error: (wide: string) => `Transferred lines are ${wide}. The grey band is their 90 % band.`,
    bridged: (bridged: number, points: number) => `${bridged} of ${points} points lie over holes of that scan and are dashed.`,
  },

  announceAdded: "The second scan is here. Landmarks and fit are its own.",
  announceSwapped: (name: string) => `Now working on the ${name} scan.`,
};
