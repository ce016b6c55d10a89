import type { PlanLesion } from "../../api/types";

/** What is kept of the plan in words and numbers, see plan/actions.ts. */
export interface PlanWords {
  note(text: string): void;
  depth(mm: number | null): void;
  lesions(lesions: readonly PlanLesion[]): void;
}
