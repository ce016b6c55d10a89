// Slices through a body, with one cross in all of them: whose are open, where the cross is, which one is enlarged.
import type { Vector } from "../../api/types";

export const PLANES = ["axial", "sagittal", "coronal"] as const;
export type Plane = (typeof PLANES)[number];

export interface SlicesState {
  readonly of: string | null; // code of the patient for whom they are open
  readonly cross: { readonly scan: string; readonly at: Vector } | null; // mm, in that scan's axes; null: in the lesion that is looked at
  readonly enlarged: Plane | "body" | null;
  readonly moves: boolean; // the lesion goes where the cross goes
  readonly marks: readonly Vector[] | null; // of a lesion that is being marked: its centre, and a place on its edge; null: none is
}

export const initialSlices: SlicesState = { of: null, cross: null, enlarged: null, moves: false, marks: null };

interface Seen {
  readonly slices: SlicesState;
  readonly scan: { readonly info: { readonly patient_code: string } } | null;
}

export const areSlicesOpen = ({ slices, scan }: Seen): boolean => scan !== null && slices.of === scan.info.patient_code;

/** Opened, or closed. */
export const withSlices = (state: Seen, isOn: boolean): { slices: SlicesState } => ({ slices: isOn ? { ...state.slices, of: state.scan?.info.patient_code ?? null } : initialSlices });
