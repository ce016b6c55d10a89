// The result: numbers, distances, files.

import { capital, word } from "../languages/words";

export const result = {
  report: word("fit.result.report"),
  files: word("fit.result.files"),
  drawing: word("fit.result.drawing"),
  noDrawing: word("fit.result.noDrawing"),
  downloads: [
    { key: "report", name: "report.pdf", what: word("fit.result.downloads.1.what") },
    { key: "fitted_glb", name: "fitted.glb", what: word("fit.result.downloads.2.what") },
    { key: "fitted_ply", name: "fitted.ply", what: word("fit.result.downloads.3.what") },
    { key: "plan", name: "drawing.json", what: word("fit.result.downloads.4.what") },
    { key: "result", name: "result.json", what: word("fit.result.downloads.5.what") },
  ] as const,
};

export const fingers = { wide: [word("fit.fingers.wide.1"), word("fit.fingers.wide.2"), word("fit.fingers.wide.3"), word("fit.fingers.wide.4")] };

const fingerWidths = [word("fit.fingers.widths.1"), word("fit.fingers.widths.2"), word("fit.fingers.widths.3"), word("fit.fingers.widths.4")];

export const verdict = {
  ready: word("fit.verdict.ready"),
  check: (count: number) => word(count === 2 ? "fit.verdict.checkTwo" : count === 3 ? "fit.verdict.checkThree" : "fit.verdict.check", { count }),
  cannot: word("fit.verdict.cannot"),
  anotherFile: word("fit.verdict.anotherFile"),
  giveLength: word("fit.verdict.giveLength"),
  setPoints: word("fit.verdict.setPoints"),
  look: word("fit.verdict.look"),
  draw: (wide: string) => word("fit.verdict.draw", { wide }),
  anyLines: word("fit.verdict.anyLines"),
  lines: (lines: string, wide: string) => word("fit.verdict.linesAre", { lines: capital(lines), wide }),
  band: word("fit.verdict.band"),
  unknown: word("fit.verdict.unknown"),
  brings: (count: number, fingers: number) => word("fit.verdict.brings", { count, width: fingerWidths[fingers]! }),
};

export const distances = {
  bar: (scale: number, scanner: number) =>
    word("fit.distances.bar", { scale, scanner }),
  title: word("fit.distances.title"),
  inside: word("fit.distances.inside"),
  outside: word("fit.distances.outside"),
  scanner: word("fit.distances.scanner"),
  noScan: word("fit.distances.noScan"),
  hover: (mm: string) => word("fit.distances.hover", { mm }),
  hoverInside: word("fit.distances.hoverInside"),
  hoverOutside: word("fit.distances.hoverOutside"),
  hoverScanner: word("fit.distances.hoverScanner"),
  hoverNone: word("fit.distances.hoverNone"),
  block: word("fit.distances.block"),
  blockHint: word("fit.distances.blockHint"),
  within: (mm: number) => word("fit.distances.within", { mm }),
  beyond: (mm: number) => word("fit.distances.beyond", { mm }),
  signedMean: word("fit.distances.signedMean"),
};

export const numbers = {
  title: word("fit.numbers.title"),
  verdicts: { good: word("fit.numbers.verdicts.good"), uncalibrated: word("fit.numbers.verdicts.uncalibrated"), check: word("fit.numbers.verdicts.check"), unusable: word("fit.numbers.verdicts.unusable") },
  unknown: word("fit.numbers.unknown"),
  lines: word("fit.numbers.lines"),
  drawnLines: word("fit.numbers.drawnLines"),
  radiusUnknown: word("fit.numbers.radiusUnknown"),
  outdated: {
    gone: word("fit.numbers.outdated.gone"),
    landmarks: word("fit.numbers.outdated.landmarks"),
    cuts: word("fit.numbers.outdated.cuts"),
    settings: word("fit.numbers.outdated.settings"),
  },
  again: word("fit.numbers.again"),
  solver: word("fit.numbers.solver"),
  live: word("fit.numbers.live"),
  surface: word("fit.numbers.surface"),
  predicted: word("fit.numbers.predicted"),
  surfaceHint: word("fit.numbers.surfaceHint"),
  scanToModel: word("fit.numbers.scanToModel"),
  scanToModelHint: word("fit.numbers.scanToModelHint"),
  landmarks: word("fit.numbers.landmarks"),
  landmarksHint: word("fit.numbers.landmarksHint"),
  radius: (mm: string) => `±\u00a0${mm}`,
  eachHint: word("fit.numbers.eachHint"),
  run: word("fit.numbers.run"),
  mean: word("fit.numbers.mean"),
  std: word("fit.numbers.std"),
  p95: "95 %",
  max: word("fit.numbers.max"),
  meanDistance: word("fit.numbers.meanDistance"),
  aloneHint: word("fit.numbers.aloneHint"),
  aloneBlock: word("fit.numbers.aloneBlock"),
  landmarkDistance: word("fit.numbers.landmarkDistance"),
  coverage: word("fit.numbers.coverage"),
  coverageHint: word("fit.numbers.coverageHint"),
  iterations: word("fit.numbers.iterations"),
  stage: word("fit.numbers.stage"),
  stance: word("fit.numbers.stance"),
  arms: word("fit.numbers.arms"),
  armsHint: word("fit.numbers.armsHint"),
  armsOf: (angles: { L?: number; R?: number }) => [angles.L === undefined ? "" : word("fit.numbers.armLeft", { degrees: angles.L }), angles.R === undefined ? "" : word("fit.numbers.armRight", { degrees: angles.R })].filter(Boolean).join(", "),
  elapsed: word("fit.numbers.elapsed"),
  solve: word("fit.numbers.solve"),
  total: word("fit.numbers.total"),
  stop: word("fit.numbers.stop"),
  noLandmarks: word("fit.numbers.noLandmarks"),
  each: word("fit.numbers.each"),
};
