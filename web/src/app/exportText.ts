// What is written into an exported picture, and the menu that offers all files.

import { word } from "../languages/words";

export const files = {
  scale: word("app.files.scale"),
  saveAs: "view.png",
  ofPlan: { template: "template.pdf", left: "guide.stl?side=L", right: "guide.stl?side=R", dicom: "dicom.zip" } as const,
  lines: "lines.json",
  linesHint: word("app.files.linesHint"),
  distances: "distances.csv",
  distancesHint: word("app.files.distancesHint"),
  failed: word("app.files.failed"),
};

export type OfPlan = keyof typeof files.ofPlan;
