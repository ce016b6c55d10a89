// What one patient holds on the graphics card is let go before the next one comes.
import { expect, type Page } from "@playwright/test";
import { hook, openDetails, test, until, untilFitted, untilStill } from "./page";

const OPENED = 6; // each twice: what is left of one is seen at its next

const memory = (page: Page) => page.evaluate(() => window.__breastrig!.memory());
type Memory = Awaited<ReturnType<typeof memory>>;
const goTo = (page: Page, hash: string) => page.evaluate((to) => void (location.hash = to), hash);

/** The model, posed as in the first iteration and then as in the last, the surface with its lines and their bands. */
async function wholeResult(page: Page): Promise<void> {
  await untilFitted(page);
  await until(page, () => window.__breastrig!.state().fit?.distances);
  await openDetails(page);
  const slider = page.locator("#iteration");
  await slider.fill("0");
  const textures = async (): Promise<number> => {
    await hook.picture(page);
    return (await memory(page)).textures;
  };
  await expect.poll(textures, "the rig's shapes are a texture").toBeGreaterThan(0);
  await slider.fill((await slider.getAttribute("max"))!);
}

test(`after ${OPENED} scans the graphics card holds what it held after the first`, async ({ page, base, troubles }) => {
  const api = async <Body>(path: string, data: object = {}): Promise<Body> => (await (await page.request.post(base + path, { data })).json()) as Body;
  const [standing, supine] = [await api<{ id: string }>("/api/examples/standing"), await api<{ id: string }>("/api/examples/supine")];
  const fit = await api<{ id: string; links: { self: string } }>("/api/fits", { scan: standing.id });
  await expect.poll(async () => ((await (await page.request.get(base + fit.links.self)).json()) as { state: string }).state).toBe("done");
  const patients = [
    { hash: `#scan=${standing.id}&fit=${fit.id}&step=body`, shown: () => wholeResult(page) },
    ...[supine, standing].map(({ id }) => ({ hash: `#scan=${id}&step=body`, shown: () => Promise.resolve() })),
  ];
  await page.goto(base);
  await goTo(page, patients[2]!.hash); // in its own colours: with the result it may come to the screen in grey only
  await hook.ready(page);
  await hook.picture(page);
  await goTo(page, "#");
  await until(page, () => window.__breastrig!.state().scan === null);
  const order = Array.from({ length: OPENED }, (_, i) => i % patients.length);
  const seen: { open: Memory; closed: Memory }[] = [];
  for (const which of order) {
    const { hash, shown } = patients[which]!;
    await goTo(page, hash);
    await hook.ready(page);
    await shown();
    await untilStill(page);
    await hook.picture(page); // all of it has been drawn
    const before = seen[order.indexOf(which)]?.open;
    const drawn = async (): Promise<Memory> => (await hook.picture(page), memory(page));
    if (before) await expect.poll(drawn, `scan ${seen.length + 1}`).toEqual(before); // a busy machine draws its last part late
    const open = await memory(page);
    await goTo(page, "#");
    await until(page, () => window.__breastrig!.state().scan === null);
    await hook.picture(page);
    seen.push({ open, closed: await memory(page) });
  }
  console.log(`on the graphics card: first ${JSON.stringify(seen[0])}, after ${OPENED} scans ${JSON.stringify(seen.at(-1))}`);
  for (const [i, each] of seen.entries()) expect(each, `scan ${i + 1}`).toEqual({ open: seen[order.indexOf(order[i]!)]!.open, closed: seen[0]!.closed });
  for (const { open, closed } of seen) expect(open.programs, "none is made again for the next scan").toBe(closed.programs);
  expect(troubles).toEqual([]);
});
