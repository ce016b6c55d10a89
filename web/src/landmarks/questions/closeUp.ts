// The eye comes near to where the wanted landmark is expected: where it was placed, where the fitted model has it, or where
// it is proposed.  Without any of these the person looks for it on the whole body.
import { Vector3 } from "three";
import type { Unit, Vector } from "../../api/types";
import { only, type Store } from "../../store/store";
import { metresFromMm, mmFrom } from "../../ui/units";
import type { Surface } from "../../viewer/picking";
import type { Viewer } from "../../viewer/Viewer";
import type { Judgement } from "./questions";
import type { MarksSlice } from "../marks/marks";
import type { LandmarksSlice } from "../state";

type Fitted = (Judgement & { readonly result: { readonly landmarks?: Readonly<Record<string, Vector>>; readonly scan?: { readonly unit: string } } | null }) | null;

type Shown = Pick<LandmarksSlice & MarksSlice, "active" | "picks" | "proposals" | "beside"> & { readonly fit: Fitted };

/** Millimetres, scan's axes. */
export function expectedAt({ active, picks, proposals, beside, fit }: Shown): Vector | null {
  if (active === null) return null;
  const { landmarks, scan } = fit?.result ?? {};
  const fitted = landmarks?.[active]?.map((value) => mmFrom(value, (scan?.unit ?? "mm") as Unit)) as Vector | undefined;
  const proposed = proposals?.state === "found" ? proposals.landmarks[active]?.point : undefined;
  return picks.present[active] ?? fitted ?? proposed ?? beside[active] ?? null;
}

export function followWanted(viewer: Viewer, scan: Surface, store: Pick<Store<Shown>, "get" | "select">): void {
  store.select(only("active"), ({ active }, before) => {
    if (active === before.active) return;
    const place = expectedAt(store.get());
    if (place) viewer.closeUp(place, scan.normalAt(new Vector3(...place.map(metresFromMm))));
    else if (active === null) viewer.closeUp(null);
  });
}
