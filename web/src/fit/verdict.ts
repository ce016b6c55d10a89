// How far a fit may be trusted, in words: the service's own verdict, before any number.
import type { Result } from "../api/types";
import * as text from "./text";

const words = text.numbers;

/** good where a result of an older version has no verdict, so that nothing is called doubtful without a reason. */
export const levelOf = (result: Pick<Result, "verdict"> | null | undefined): NonNullable<Result["verdict"]>["level"] => result?.verdict?.level ?? "good";

/** In one line, for those who listen. */
export const verdictWords = ({ verdict }: Pick<Result, "verdict">): string => (verdict ? [`${words.verdicts[verdict.level]}.`, ...verdict.reasons].join(" ") : "");
