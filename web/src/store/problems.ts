// What went wrong, kept in the state at the place where it is shown.
import { ApiError } from "../api/client";
import { unexpected } from "../api/text";
import type { PageSlice, Place } from "./page";

export function withProblem(state: Pick<PageSlice, "problems">, place: Place, message: string | null): Pick<PageSlice, "problems"> {
  const { [place]: _old, ...rest } = state.problems;
  return { problems: message === null ? rest : { ...rest, [place]: message } };
}

/** Takes away this message alone: another one that came meanwhile stays, for nobody has mended it. */
export const withoutMessage = (state: Pick<PageSlice, "problems">, place: Place, message: string | null): Partial<Pick<PageSlice, "problems">> =>
  message !== null && state.problems[place] === message ? withProblem(state, place, null) : {};

export function messageOf(error: unknown): string {
  if (error instanceof ApiError) return error.message;
  return unexpected(error instanceof Error ? error.message : String(error));
}
