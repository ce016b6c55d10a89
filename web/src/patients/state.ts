// The list to work through: patients under codes, as the service pages them.
import type { Patient } from "../api/types";

export type Order = "newest" | "code" | "deletion";

export interface PatientsState {
  readonly rows: readonly Patient[]; // in the order that the service gives
  readonly next: string | null; // address of the next page
  readonly search: string;
  readonly order: Order;
  readonly isBusy: boolean;
  readonly isKnown: boolean; // the list was read once
  readonly going: readonly string[]; // that will be deleted unless the person takes it back
}

export interface PatientsSlice {
  readonly patients: PatientsState;
}

export const initialPatients: PatientsState = { rows: [], next: null, search: "", order: "newest", isBusy: false, isKnown: false, going: [] };

/** The time when the patient's first scan is deleted by age; null: never. */
export function deletedAt({ scans }: Pick<Patient, "scans">): string | null {
  const days = scans.map(({ delete_at }) => delete_at).filter((each) => each !== null).sort();
  return days[0] ?? null;
}

/** Whole days from now, none of them negative. */
export const daysUntil = (at: string, now: Date): number => Math.max(0, Math.floor((new Date(at).getTime() - now.getTime()) / 86_400_000));
