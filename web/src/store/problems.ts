// What went wrong, kept in the state at the place where it is shown.
import type { Place, Session } from "../app/session";
import { ApiError } from "../api/client";
import { text } from "../ui/text";

export function withProblem(state: Session, place: Place, message: string | null): Pick<Session, "problems"> {
  const { [place]: _old, ...rest } = state.problems;
  return { problems: message === null ? rest : { ...rest, [place]: message } };
}

export function messageOf(error: unknown): string {
  if (error instanceof ApiError) return error.message;
  return text.errors.unexpected(error instanceof Error ? error.message : String(error));
}
