// Keys while the lasso is in the hand; they go before the page's own.
import type { ScanActions } from "./actions";
import type { ScanSlice } from "./state";

/** Does what the key stands for; false leaves it to the page. */
export function cropKey({ isCropping }: Pick<ScanSlice, "isCropping">, event: KeyboardEvent, actions: Pick<ScanActions, "takeLasso" | "undoCrop" | "redoCrop">): boolean {
  if (!isCropping) return false;
  const key = event.key.toLowerCase();
  if (key === "z") return (event.shiftKey ? actions.redoCrop() : actions.undoCrop()), true;
  if (key === "y") return actions.redoCrop(), true;
  if (key === "escape") return actions.takeLasso(false), true;
  return false;
}
