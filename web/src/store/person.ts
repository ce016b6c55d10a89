// Who is signed in, and what that person may do; where the service has no users everybody may do everything.
import type { Meta } from "../api/types";
import type { PageSlice } from "./page";

export const mayPlan = ({ meta }: Pick<PageSlice, "meta">): boolean => meta?.person?.role !== "look";

/** The groups that a patient can be given to. */
export const allGroups = (meta: Meta | null): readonly string[] => meta?.person?.all_groups ?? [];

/** The groups one of which a person chooses for new patients; empty where there is nothing to choose. */
export function groupsForNew(meta: Meta | null): readonly string[] {
  const { groups = [], all_groups: all = [] } = meta?.person ?? {};
  return all.length > 0 ? all : groups.length > 1 ? groups : [];
}

/** Nobody but the person knows which group a new patient belongs to. */
export const isGroupMissing = ({ meta, group }: Pick<PageSlice, "meta" | "group">): boolean => group === "" && (meta?.person?.groups.length ?? 0) > 1;
