// The scan on the page, and how it came there.
import type { Frame, LandmarkFile, Scan, UnitChoice } from "../api/types";

export interface ScanState {
  readonly info: Scan;
  readonly title: string;
  readonly mesh: ArrayBuffer | null; // glTF binary, metres, the scan's own axes; null behind a link that does not show it
  readonly frame: Frame;
  readonly frameFrom: "service" | "landmarks" | "fit" | "person"; // who says so; the last of these wins
  readonly file: File | null; // kept, so that another unit needs no second choosing
  readonly example: LandmarkFile | null;
}

export interface ScanSlice {
  readonly loading: { readonly phase: "sending" | "preparing"; readonly share: number; readonly title: string } | null;
  readonly scan: ScanState | null;
  readonly confirmed: string | null; // the scan whose size and direction a person has called right
  readonly showColours: boolean;
  readonly units: UnitChoice;
}

export const initialScan: ScanSlice = { loading: null, scan: null, confirmed: null, showColours: true, units: "auto" };
