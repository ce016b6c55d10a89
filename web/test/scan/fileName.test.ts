// Names of files: whose, of which stance and day, in characters that every system takes; as core/identity.py makes them.
import { expect, test } from "vitest";
import type { Scan } from "../../src/api/types";
import { fileName } from "../../src/scan/state";

const scan = (patient_code: string) => ({ info: { patient_code, created_at: "2026-11-25T09:10:11.000Z", stance: { proposed: "standing" } } as unknown as Scan });

test("the code, the stance and the day stand in every file's name", () => {
  expect(fileName(scan("K7M-4QX"), "drawing.json")).toBe("K7M-4QX_standing_2026-11-25_drawing.json");
  expect(fileName(scan("Klinik Süd/7 ; x"), "view.png", "supine")).toBe("Klinik-Sud-7-x_supine_2026-11-25_view.png");
  expect(fileName(scan("??"), "view.png")).toBe("no-code_standing_2026-11-25_view.png");
});
