// The true size of a scan.
const cm = (mm: number): string => `${(mm / 10).toFixed(1)}\u00a0cm`;

export const size = {
  label: "True size",
  ask: "Many phone apps are off by some per cent. Measure a straight length on the patient, such as notch to nipple, or put a ruler into the scan, and give it here. Without it all errors take the scan's size as true.",
  askUnknown: "The file of this scan does not say how large the patient is. Measure a straight length on the patient, such as notch to nipple, and give it here. Until then all errors are larger.",
  measure: "Click both ends",
  stop: "Stop",
  ends: { from: "From", to: "To" },
  clicked: "a place that is clicked",
  clickFrom: "Click the first end on the scan.",
  clickTo: "Click the other end.",
  inScan: (mm: number) => `In the scan it is ${cm(mm)}.`,
  field: "On the patient",
  hint: "The straight way between both ends, not along the skin.",
  apply: "Apply",
  applyHint: "The scan, and what is placed and drawn on it, is scaled; it is fitted again.",
  remove: "Take out",
  removeHint: "The scan has the size of its file again.",
  scaled: (factor: number, from: string, to: string, mm: number) => `Scaled by ${factor.toFixed(3)}: ${from} to ${to} is ${cm(mm)}.`,
  places: ["one place", "another"] as readonly string[], // as the service calls ends without a name
  protocol: "A page to print for taking scans with marks and a length",
  applied: "The scan has its true size.",
  elsewhere: "The scan was given another size elsewhere. The page shows it in that size.",
  removed: "The scan has the size of its file.",
  change: "true size",
  undone: (to: { readonly factor: number } | null) => `Undone: the scan ${to ? `is scaled by ${to.factor.toFixed(3)}` : "has the size of its file"}.`,
  redone: (to: { readonly factor: number } | null) => `Redone: the scan ${to ? `is scaled by ${to.factor.toFixed(3)}` : "has the size of its file"}.`,
};
