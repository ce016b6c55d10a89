// A fit's drawing is asked for by a text: drawings of the model and patterns with parameters, joined by "+".
// Drawings of the model are known beforehand and ride along; a pattern is measured on the fitted skin, at the end.
import type { ModelShape, ModelSide } from "../api/types";

const partsOf = (asked: string | null): string[] => (asked ?? "").split("+").filter((part) => part !== "");
const find = (side: ModelSide, part: string): ModelSide["drawings"][number] | undefined => side.drawings.find(({ name }) => name === part);

/** The lines that lie on the model from the first iteration on. */
export function shapesOnModel(side: ModelSide | null, asked: string | null): readonly ModelShape[] {
  return side ? partsOf(asked).flatMap((part) => find(side, part)?.shapes ?? []) : [];
}

/** Some of it comes only when the fit has ended. */
export const hasPattern = (side: ModelSide | null, asked: string | null): boolean => side !== null && partsOf(asked).some((part) => !find(side, part));
