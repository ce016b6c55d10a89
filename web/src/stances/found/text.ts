// Marks found by colour.
export const found = {
  title: "Marks by colour",
  hint: "Dots and crosses of a pen, and moles, that both scans show. A pair is followed only once you have accepted it.",
  noColours: "Marks can be found where both scans have fine colours: one of these has none, or too coarse ones.",
  find: "Find marks",
  looking: "Looking for marks on both scans\u2026",
  row: (name: string, kind: string, offMm: number) => `${name}, ${kind}, ${offMm.toFixed(0)} mm from where it was expected`,
  accept: (name: string) => `Accept the mark ${name}`,
  dismiss: (name: string) => `Dismiss the mark ${name}`,
  acceptAll: (count: number) => `Accept all ${count}`,
  dismissAll: "Dismiss all",
  announceAccepted: (names: readonly string[]) => `Marks on both scans: ${names.join(", ")}.`,
};
