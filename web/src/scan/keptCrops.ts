// What was hidden by hand stays hidden when the page is loaded again or another scan was looked at meanwhile: in this tab's
// memory alone, until the scan is deleted or the tab is closed.
import { type Crop, type Crops, NO_CROPS } from "./crop";

export type TabMemory = Pick<Storage, "getItem" | "setItem" | "removeItem">;

const keyOf = (scan: string): string => `breastrig.hidden.${scan}`;

export function keepCrops(memory: TabMemory | null, scan: string, crops: Crops): void {
  try {
    if (crops.length > 0) memory?.setItem(keyOf(scan), JSON.stringify(crops));
    else memory?.removeItem(keyOf(scan));
  } catch {
    // a tab that may remember nothing hides it until it is loaded again
  }
}

/** None where nothing was kept, or nothing that can be read. */
export function keptCrops(memory: TabMemory | null, scan: string): Crops {
  try {
    const kept: unknown = JSON.parse(memory?.getItem(keyOf(scan)) ?? "[]");
    return Array.isArray(kept) && kept.every(isCrop) ? kept : NO_CROPS;
  } catch {
    return NO_CROPS;
  }
}

function isCrop(kept: unknown): kept is Crop {
  const { toPicture, lasso } = (kept ?? {}) as Partial<Record<keyof Crop, unknown>>;
  const areNumbers = (list: unknown, count: number): boolean => Array.isArray(list) && list.length === count && list.every(Number.isFinite);
  return areNumbers(toPicture, 16) && Array.isArray(lasso) && lasso.length > 2 && lasso.every((corner) => areNumbers(corner, 2));
}
