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
    offer: "No such scan at hand",
    offerWhat: "Predicted from this scan, with how far off it may be. Nothing can be drawn on it; a scan takes its place.",
    predict: (stance: string) => `Predict ${stance}`,
    needsFit: "Fit this scan first: a stance is predicted from its fit.",
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
    code: "Her code there",
    find: "Show its scans",
    nobody: (code: string) => `No other patient here has the code “${code}”; type it as it is in the list.`,
    moves: (code: string, there: string) => `Choose one of ${there} only if it shows the same woman: it will be filed under ${code} then.`,
    at: (stance: string, when: string) => `${capital(stance)}, ${when}`,
    busy: "Loading the scan …",
  },

  carry: {
    title: "On the other stance",
    needsFits: (names: string) => `A drawing is carried between two fitted scans. Not fitted yet: ${names}.`,
    needsLines: "Draw a line or choose a pattern on either scan: it is shown on the other as well.",
    others: "the patient's other scans",
    busy: "Carrying the drawing …",
    done: (name: string) => `Shown on the ${name} scan, lines and patterns; it follows every change.`,
    donePredicted: (name: string) => `Shown on the ${name} body, predicted and not scanned, lines and patterns; it follows every change.`,
    error: (wide: string) => `Carried lines are ${wide}: the grey band holds the true line nine times in ten.`,
    bridged: (bridged: number, points: number) => `${bridged} of ${points} points lie over holes of that scan and are dashed.`,
  },

  announceAdded: "The second scan is here. Landmarks and fit are its own.",
  announceSwapped: (name: string) => `Now working on the ${name} scan.`,
};
