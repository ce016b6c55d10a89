// Picks that the fit did not follow, as sentences with the landmarks' labels in place of their names.
import type { FitState } from "./state";

/** What is known so far: all of it with the result, before that what the start found from the picks alone. */
export function landmarkWarnings(fit: FitState, labels: ReadonlyMap<string, string>): string[] {
  const warnings = fit.result?.landmarks_not_followed ?? fit.started?.landmarks_not_followed ?? [];
  return warnings.map(({ names, reason }) => {
    const labelled = names.reduce((sentence, name) => sentence.replaceAll(name, labels.get(name) ?? name), reason);
    return labelled.charAt(0).toUpperCase() + labelled.slice(1);
  });
}

export const labelsOf = (landmarks: readonly { name: string; label: string }[] = []): Map<string, string> =>
  new Map(landmarks.map(({ name, label }) => [name, label]));
