// Files that come together: one patient, each scan fitted by itself, landmarks where they lie, and nothing guessed.
import { afterEach, expect, test, vi } from "vitest";
import { ApiError, type UploadFields } from "../../src/api/client";
import type { Fit, FitRequest, Patient, Question, Scan } from "../../src/api/types";
import { bringing as words } from "../../src/app/text";
import { fitLinks, page, scanInfo } from "../fakes";

afterEach(() => vi.unstubAllGlobals());

const file = (name: string, content = "x"): File => new File([content], name);
const bounds = (low: number, high: number) => ({ bounds_m: { min: [low, low, low], max: [high, high, high] } }) as unknown as Partial<Scan>;
const landmarks = (x: number): string => JSON.stringify({ unit: "mm", landmarks: { nipple_L: [x, 100, 100] } });

/** A service that keeps what is uploaded under the file's name, of one patient where that is said. */
function service(about: Record<string, Partial<Scan>> = {}, fitsAtOnce = true) {
  const sent: [string, UploadFields][] = [];
  const upload = async (given: File, fields: UploadFields): Promise<Scan> => {
    sent.push([given.name, fields]);
    return { ...scanInfo(given.name), patient: fields.patient ?? "p", ...bounds(0, 1), ...about[given.name] };
  };
  const startFit = vi.fn(async ({ scan }: FitRequest) => ({ id: `fit of ${scan}`, links: fitLinks(`fit of ${scan}`), cuts: "" }));
  const scan = async (id: string) => ({ ...scanInfo(id), patient: "p", ...bounds(0, 1), ...about[id] });
  const patient = async (id: string) => ({ id, code: "K7M-4QX", scans: sent.map(([name]) => ({ id: name, stance: "standing", kind: "surface", created_at: "2026-11-25T09:00:00Z", thumbnail: "", fit: null })) }) as unknown as Patient;
  const fit = async (id: string) => ({ id, links: fitLinks(id), state: "running", drawing: null }) as unknown as Fit;
  const made = page({ upload, startFit, scan, patient, fit, allEvents: async () => [] });
  made.store.set({ fitsAtOnce });
  return { ...made, sent, startFit };
}

test("three files become one patient: the first scan on the page, the next beside it, the image on the strip, each fitted by itself", async () => {
  const { store, actions, sent, startFit } = service();
  await actions.bring.files([file("mri.nii.gz"), file("standing.ply"), file("supine.obj")]);
  expect(sent.map(([name, { patient }]) => [name, patient]), "the image comes last").toEqual([["standing.ply", undefined], ["supine.obj", "p"], ["mri.nii.gz", "p"]]);
  expect(startFit.mock.calls.map(([{ scan }]) => scan)).toEqual(["standing.ply", "supine.obj", "mri.nii.gz"]);
  expect(store.get()).toMatchObject({ scan: { info: { id: "standing.ply" } }, stances: { isComparing: true, isSecond: false, other: { scan: { info: { id: "supine.obj" } }, fit: { id: "fit of supine.obj" } } } });
  expect(store.get().stances.scans.map(({ id }) => id)).toEqual(["standing.ply", "supine.obj", "mri.nii.gz"]);
  expect(store.get().problems).toEqual({});
});

test("a size that may be wrong is asked about before anything is fitted; who says that it is right has it fitted", async () => {
  const doubt = { size_doubt: "The body would be 53 m tall." } as Partial<Scan>;
  const { actions, startFit } = service({ "a.ply": doubt, "b.ply": doubt });
  await actions.bring.files([file("a.ply"), file("b.ply")]);
  expect(startFit).not.toHaveBeenCalled();
  actions.bring.sizeIsRight();
  await vi.waitFor(() => expect(startFit.mock.calls.map(([{ scan }]) => scan)).toEqual(["a.ply"]));
});

test("who wishes so fits when it is time, not at once", async () => {
  const { actions, startFit } = service({}, false);
  await actions.bring.files([file("a.ply"), file("b.ply")]);
  expect(startFit).not.toHaveBeenCalled();
});

test("landmarks go to the one scan that they lie on; where that may be several, or none, they are not taken, and it is said", async () => {
  const { store, client, actions } = service({ "a.ply": bounds(0, 0.3), "b.ply": bounds(1, 2) }, false);
  await actions.bring.files([file("a.ply"), file("b.ply"), file("of_a.json", landmarks(200))]);
  expect(store.get().picks.present).toEqual({ nipple_L: [200, 100, 100] });
  const both = service({}, false);
  await both.actions.bring.files([file("a.ply"), file("b.ply"), file("either.json", landmarks(200)), file("note.txt~")]);
  expect(both.store.get().picks.present).toEqual({});
  expect(both.client.saveLandmarks).not.toHaveBeenCalled();
  expect(both.store.get().problems.scan).toBe(`${words.notTaken(1)} ${words.unplaced(1)}`);
  expect(client.saveLandmarks).not.toHaveBeenCalledWith(expect.objectContaining({ id: "b.ply" }), expect.anything(), expect.anything());
});

test("landmarks alone go to the scan on the page; nothing that can be read is said, and nothing is left", async () => {
  const { store, actions, sent } = service({}, false);
  await actions.bring.files([file("a.ply")]);
  await actions.bring.files([file("picks.json", landmarks(5))]);
  expect(store.get().picks.present).toEqual({ nipple_L: [5, 100, 100] });
  await actions.bring.files([file("skin.jpg"), file("body.mtl")]);
  expect(sent.map(([name]) => name)).toEqual(["a.ply"]);
  expect(store.get().problems.scan).toBe(words.none(2));
});

test("of a further scan, too, the side is asked; called off, it is not added", async () => {
  const question = { problem: "Which side is left?", field: "frame", choices: [{ value: "RAS", text: "left" }] } as unknown as Question;
  const said: UploadFields[] = [];
  const upload = async ({ name }: File, fields: UploadFields): Promise<Scan> => {
    said.push(fields);
    if (name.endsWith(".nii.gz") && fields.frame === undefined) throw new ApiError("say which it is", 422, question);
    return { ...scanInfo(name), ...bounds(0, 1) };
  };
  const { store, actions } = page({ upload });
  const going = actions.bring.files([file("a.ply"), file("mri.nii.gz")]);
  await vi.waitFor(() => expect(store.get().asked).toBe(question));
  actions.scan.answer(null);
  await going;
  expect(said).toHaveLength(2);
  expect(store.get()).toMatchObject({ scan: { info: { id: "a.ply" } }, problems: {} });
});
