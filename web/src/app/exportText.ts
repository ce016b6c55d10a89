// What is written into an exported picture, and the menu that offers all files.

export const files = {
  scale: "10 cm at the middle of the body",
  saveAs: "view.png",
  ofPlan: { template: "template.pdf", left: "guide.stl?side=L", right: "guide.stl?side=R" } as const,
  lines: "lines.json",
  linesHint: "drawn by hand on this scan, mm in its frame",
  distances: "distances.csv",
  distancesHint: "of each vertex of fitted.ply, mm",
  failed: "The picture could not be made: this browser gave none. Take a screenshot instead.",
};

export type OfPlan = keyof typeof files.ofPlan;
