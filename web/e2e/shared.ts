// The service with a token and links to its results, for the tests of what visitors see.
import { createHash } from "node:crypto";
import { expect } from "@playwright/test";

export interface Link {
  readonly id: string;
  readonly url: string;
  readonly links: { readonly self: string; readonly unlock: string; readonly refresh: string };
}

interface Fit {
  readonly state: string;
  readonly links: Record<string, string>;
}

export const sha256 = (bytes: Uint8Array): string => createHash("sha256").update(bytes).digest("hex");

/** Whoever has the token of the service that all these tests share. */
export class Owner {
  private get service(): { readonly address: string; readonly data: string } {
    return JSON.parse(process.env.BREASTRIG_E2E_OWNER!) as { address: string; data: string };
  }

  /** As the service prints it: with the token that it has made itself. */
  get address(): string {
    return this.service.address;
  }

  /** The service's folder. */
  get data(): string {
    return this.service.data;
  }

  get base(): string {
    return new URL(this.address).origin;
  }

  get token(): string {
    return new URL(this.address).searchParams.get("token")!;
  }

  async ask(path: string, method = "GET", body?: object, more: Record<string, string> = {}): Promise<Response> {
    const headers = { Authorization: `Bearer ${this.token}`, "Content-Type": "application/json", ...more };
    const answer = await fetch(this.base + path, { method, headers, ...(body ? { body: JSON.stringify(body) } : {}) });
    expect(answer.ok, `${method} ${path}: ${answer.status}`).toBe(true);
    return answer;
  }

  async json<Body>(path: string, method = "GET", body?: object): Promise<Body> {
    return (await (await this.ask(path, method, body)).json()) as Body;
  }

  async hash(path: string): Promise<string> {
    return sha256(new Uint8Array(await (await this.ask(path)).arrayBuffer()));
  }

  /** A fit of one of the example's stances, done; its links and those of its scan. */
  async fitted(stance: "standing" | "supine"): Promise<{ scan: Record<string, string>; fit: Record<string, string> }> {
    const scan = await this.json<{ id: string; links: Record<string, string> }>(`/api/examples/${stance}`, "POST");
    const fit = await this.json<Fit>("/api/fits", "POST", { scan: scan.id });
    await expect.poll(async () => (await this.json<Fit>(fit.links.self!)).state).toBe("done");
    return { scan: scan.links, fit: fit.links };
  }

  /** What the link offers to a visitor who opens nothing else: sha256 of each file, by the name under which it is taken away. */
  async offered(link: Link): Promise<Record<string, string>> {
    const open = await fetch(`${this.base}/api/shared/open`, { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify({ token: link.url.split("#")[1] }) });
    const headers = { Cookie: open.headers.getSetCookie().map((each) => each.split(";")[0]).join("; ") };
    const { links } = (await open.json()) as { links: Record<string, string | null> };
    const files = ["fitted_glb", "fitted_ply", "drawing", "result", "report", "mesh"].flatMap((name) => links[name] ?? []);
    const found = await Promise.all(files.map((path) => fetch(this.base + path, { headers })));
    const name = (answer: Response): string => answer.headers.get("Content-Disposition")!.split("filename=")[1]!;
    return Object.fromEntries(await Promise.all(found.map(async (each) => [name(each), sha256(new Uint8Array(await each.arrayBuffer()))] as const)));
  }

  share = (fit: Record<string, string>, wishes: object = {}): Promise<Link> => this.json<Link>(fit.shares!, "POST", wishes);
}
