// The share dialog: whether it is open, and the links to the result that are known.
import type { Share } from "../api/types";

export interface ShareSlice {
  readonly share: {
    readonly isOpen: boolean;
    readonly isBusy: boolean;
    readonly list: readonly Share[] | null; // null until the service has answered
    readonly made: { readonly id: string; readonly url: string } | null; // the link just made: its address is shown only once
  };
}

export const initialShare: ShareSlice = { share: { isOpen: false, isBusy: false, list: null, made: null } };
