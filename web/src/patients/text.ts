// Words of the list of patients.
import { plural } from "../ui/plural";

export const patients = {
  title: "Patients",
  search: "Search codes",
  order: "Order",
  orders: { newest: "Newest first", code: "By code", deletion: "Deleted soonest" },
  code: "Code, never a name",
  noCode: "the patient without a code",
  none: (search: string) => `No code holds “${search}”.`,
  more: "Show more",
  scans: (stances: readonly string[]) => (stances.length === 0 ? "no scan" : stances.join(" and ")),
  fitted: { done: "fitted", running: "being fitted", queued: "waiting", failed: "fit failed", cancelled: "not fitted", none: "not fitted" },
  verdicts: { good: "", uncalibrated: ", not calibrated", check: ", look at it", unusable: ", not usable" },
  plan: "planned",
  noPlan: "nothing planned",
  left: (days: number) => (days === 0 ? "deleted today" : `deleted in ${plural(days, "day", "days")}`),
  kept: "kept until you delete it",
  open: (code: string) => `Open ${code}`,
  remove: (code: string) => `Delete ${code}`,
  sure: (code: string, scans: number) =>
    `Delete ${code}: ${plural(scans, "scan", "scans")} with landmarks, fits, plan, reports and every link that shows them?`,
  yes: "Delete",
  no: "Keep",
  going: (code: string) => `${code} will be deleted in ten seconds.`,
  undo: "Take it back",
  announceGone: (code: string) => `${code} is deleted.`,
};
