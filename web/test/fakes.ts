// A page without a browser: the real store and actions, a client that answers what the test says.
import { vi } from "vitest";
import { ApiError, type Client } from "../src/api/client";
import type { Cut, LandmarkDefinition, LandmarkFile, Patient, PlanItem, PlanOnScan, Scan, StoredPlan, Vector } from "../src/api/types";
import { createActions } from "../src/app/actions";
import { withPlacingView } from "../src/app/placingView";
import { initialSession, type Session } from "../src/app/session";
import { createOutbox } from "../src/store/outbox";
import { createStore } from "../src/store/store";

/** A fitted surface of one triangle. */
const TRIANGLE = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

export const NAMES = ["suprasternal_notch", "nipple_L", "nipple_R", "umbilicus"];

export function scanInfo(id: string): Scan {
  const links = { self: `/api/scans/${id}`, mesh: `/api/scans/${id}/mesh.glb`, landmarks: `/api/scans/${id}/landmarks`, drawing: `/api/scans/${id}/drawing`, patient: `/api/patients/of-${id}`, plan: `/api/patients/of-${id}/plan` };
  const stance = { proposed: "standing", reason: "" };
  const frame = { up: [0, 1, 0] as Vector, front: [0, 0, 1] as Vector, confidence: 1, reason: "" };
  return { id, patient: `of-${id}`, patient_code: `code of ${id}`, sha256: `sha256 of ${id}`, created_at: "2026-11-25T09:00:00.000Z", unit: "m", model: "torso", frame, stance, links, colours: "none", notes: [], triangles: 1 } as unknown as Scan;
}

export function fitLinks(id: string) {
  const at = (name: string): string => `/api/fits/${id}/${name}`;
  return {
    self: `/api/fits/${id}`,
    events: at("events"),
    result: at("result.json"),
    result_zip: at("result.zip"),
    fitted_glb: at("fitted.glb"),
    report: at("report.pdf"),
    fitted_ply: at("fitted.ply"),
    drawing: at("drawing.json"),
    distances: at("distances.bin"),
    uncertainty: at("uncertainty.bin"),
    checks: at("checks"),
    plan: at("plan.json"),
    measures: at("measures.json"),
    cancel: at("cancel"),
    moved: at("moved"),
    shares: at("shares"),
    predictions: at("predictions"),
  };
}

/** Stands in for the browser's EventSource; the test speaks through `say`. */
export class FakeEventSource {
  static last: FakeEventSource | null = null;
  readyState = 1;
  private readonly listeners = new Map<string, (message: unknown) => void>();
  private number = 0;
  constructor(readonly url: string) {
    FakeEventSource.last = this;
  }
  addEventListener(kind: string, listener: (message: unknown) => void): void {
    this.listeners.set(kind, listener);
  }
  close(): void {
    this.readyState = 2;
  }
  say(kind: string, body: object): void {
    this.number += 1;
    this.listeners.get(kind)?.({ data: JSON.stringify({ kind, ...body }), lastEventId: String(this.number) });
  }
}

/** A service that keeps plans, and refuses what was not changed from the newest. */
export function fakePlans() {
  const versions = new Map<string, StoredPlan[]>();
  const all = (link: string): StoredPlan[] => versions.get(link) ?? versions.set(link, [{ schema: "breastrig/plan@1", unit: "mm", version: 0, seen: "0", whole: false, scans: [], items: [] }]).get(link)!;
  return {
    plan: vi.fn(async (link: string) => all(link).at(-1)!),
    planVersion: async (link: string, version: number) => all(link)[version]!,
    savePlan: vi.fn(async (link: string, items: readonly PlanItem[], seen: string | null) => {
      const { version } = all(link).at(-1)!;
      if (seen !== all(link).at(-1)!.seen) throw new ApiError("Somebody has changed this plan.", 412);
      all(link).push({ ...all(link)[0]!, version: version + 1, seen: `of ${version + 1}`, whole: true, items: JSON.parse(JSON.stringify(items)) as PlanItem[] });
      return all(link).at(-1)!;
    }),
    planOnFit: vi.fn(async (link: string): Promise<PlanOnScan> => ({ schema: "breastrig/drawing@1", name: "plan", unit: "mm", notice: "", shapes: [], lesions: [], notes: [], missing: [], doubts: [], version: 1, whole: true, fit: link, carried_from: [] })),
    moveScan: vi.fn(async (_scan: string, patient: string | null) => ({ id: patient }) as Patient),
  };
}

/** A browser tab's own storage. */
export function memory(): Storage {
  const kept = new Map<string, string>();
  return {
    getItem: (key: string) => kept.get(key) ?? null,
    setItem: (key: string, value: string) => void kept.set(key, value),
    removeItem: (key: string) => void kept.delete(key),
    key: (index: number) => [...kept.keys()][index] ?? null,
    clear: () => kept.clear(),
    get length() {
      return kept.size;
    },
  };
}

export function page(answers: Partial<Client> = {}, tab: Storage = memory()) {
  vi.stubGlobal("EventSource", FakeEventSource);
  const landmarks = NAMES.map((name) => ({ name, label: name }) as LandmarkDefinition);
  const store = createStore<Session>({ ...initialSession, fitsAtOnce: false, meta: { landmarks, model: { name: "torso" }, scan_files: { endings: [".ply", ".obj", ".nii.gz", ".zip"] } } as Session["meta"] }, withPlacingView);
  const client = {
    mesh: async () => new ArrayBuffer(8),
    cuts: async () => ({ cuts: [], digest: "" }),
    saveCuts: vi.fn(async (_scan: Scan, cuts: readonly Cut[]) => ({ cuts: [...cuts], digest: cuts.length === 0 ? "" : `of ${cuts.map(({ lasso }) => lasso[0]![0]).join()}` })),
    landmarks: async () => ({ schema: "breastrig/landmarks@1", unit: "mm", landmarks: {} }),
    ...fakePlans(),
    patient: async (id: string) => ({ id, code: "K7M-4QX", scans: [] }),
    visits: async () => ({ scans: [] }),
    patients: async () => ({ patients: [], next: null }),
    proposed: async () => ({ landmarks: {}, not_proposed: {} }),
    landmarkFile: async (_scan: Scan, file: File) => JSON.parse(await file.text()) as LandmarkFile,
    saveLandmarks: vi.fn(async (_scan: Scan, file: unknown) => file),
    scan: async (id: string) => scanInfo(id),
    sayModel: vi.fn(async (scan: Scan) => ({ ...scan, model_said: true })),
    upload: async () => scanInfo("uploaded"),
    startFit: async () => ({ id: "f1", links: fitLinks("f1"), cuts: "" }),
    moved: vi.fn(async () => ({ nodes: [] })),
    checks: async () => ({ lines: "breasts", line_error_mm: null, fingers: null, expected_line_error_mm: null, expected_fingers: null, worth_it: false, checks: [], reason: null }),
    fit: async (id: string) => ({ id, links: fitLinks(id), stance: "standing", asked_stance: "auto", preset: "default", drawing: "lumpectomy", refine: true, landmarks: {}, certain: [], cuts: "" }),
    drawing: async () => ({ schema: "breastrig/drawing@1", unit: "mm", shapes: [] }),
    bytes: async () => new TextEncoder().encode(TRIANGLE.padEnd(200)).buffer, // as numbers, 50 distances
    cancel: vi.fn(async () => ({})),
    deleteScan: vi.fn(async () => undefined),
    ...answers,
  } as unknown as Client;
  return { store, client, tab, actions: createActions(store, client, () => true, createOutbox(tab)) };
}

/** The same with a scan opened. */
export async function withScan(...rest: Parameters<typeof page>) {
  const made = page(...rest);
  await made.actions.scan.open("s1", null);
  return made;
}
