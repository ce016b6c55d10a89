import { expect, test, vi } from "vitest";
import { dispatch, followFit, type Handlers, type Source } from "../../src/api/events";

class FakeSource implements Source {
  static all: FakeSource[] = [];
  readyState = 1;
  onopen: ((event: Event) => void) | null = null;
  onerror: ((event: Event) => void) | null = null;
  private readonly listeners = new Map<string, (event: MessageEvent<string>) => void>();
  constructor(readonly url: string) {
    FakeSource.all.push(this);
  }
  addEventListener(kind: string, listener: (event: MessageEvent<string>) => void): void {
    this.listeners.set(kind, listener);
  }
  close(): void {
    this.readyState = 2;
  }
  say(kind: string, id: number, body: object = {}): void {
    this.listeners.get(kind)?.({ data: JSON.stringify({ kind, ...body }), lastEventId: String(id) } as MessageEvent<string>);
  }
  fail(readyState: number): void {
    this.readyState = readyState;
    this.onerror?.({} as Event);
  }
}

function follow(whyOver?: () => Promise<string | null>) {
  FakeSource.all = [];
  const seen: string[] = [];
  const note = (kind: string) => (event: { id: number }) => void seen.push(`${kind} ${event.id}`);
  const handlers: Handlers = {
    started: note("started"),
    iterated: note("iterated"),
    done: note("done"),
    failed: note("failed"),
    cancelled: note("cancelled"),
  };
  const waiting: (() => void)[] = [];
  const onConnection = vi.fn();
  const stop = followFit("/events", {
    handlers,
    onConnection,
    ...(whyOver ? { whyOver } : {}),
    open: (url) => new FakeSource(url),
    later: (action) => waiting.push(action),
  });
  return { seen, waiting, onConnection, stop, source: FakeSource.all[0]! };
}

test("an event goes to the handler of its kind with its own body", () => {
  const handlers = { failed: vi.fn() } as unknown as Handlers;
  dispatch(handlers, { kind: "failed", id: 3, body: { reason: "no start" } });
  expect(handlers.failed).toHaveBeenCalledWith({ kind: "failed", id: 3, body: { reason: "no start" } });
});

test("events come in order, and the stream is closed after the last kind", () => {
  const { seen, source } = follow();
  source.say("started", 1);
  source.say("iterated", 2);
  source.say("done", 3);
  source.say("iterated", 4);
  expect(seen).toEqual(["started 1", "iterated 2", "done 3"]);
  expect(source.readyState).toBe(2);
});

test("an event that is sent again after a reconnection counts once", () => {
  const { seen, source } = follow();
  source.say("started", 1);
  source.say("iterated", 2);
  source.say("started", 1);
  source.say("iterated", 2);
  source.say("iterated", 3);
  expect(seen).toEqual(["started 1", "iterated 2", "iterated 3"]);
});

test("a break is announced and left to the browser while it tries again by itself", () => {
  const { onConnection, waiting, source } = follow();
  source.onopen?.({} as Event);
  source.fail(0);
  expect(onConnection.mock.calls).toEqual([[true], [false]]);
  expect(waiting).toEqual([]);
});

test("a stream that the browser gave up is opened anew after the last seen event", () => {
  const { seen, waiting, source } = follow();
  source.say("started", 1);
  source.say("iterated", 2);
  source.fail(2);
  waiting[0]!();
  expect(FakeSource.all.map((each) => each.url)).toEqual(["/events", "/events?after=2"]);
  FakeSource.all[1]!.say("iterated", 3);
  expect(seen.at(-1)).toBe("iterated 3");
});

test("after stopping nothing is heard and nothing opened", () => {
  const { seen, waiting, source, stop } = follow();
  source.fail(2);
  stop();
  waiting[0]!();
  source.say("started", 1);
  expect(seen).toEqual([]);
  expect(FakeSource.all.length).toBe(1);
});

test("a fit that is gone is said once and not asked for again; one whose service is away is", async () => {
  const reasons: (string | null)[] = [null, "Its scan was deleted."];
  const { seen, waiting, source } = follow(async () => reasons.shift()!);
  source.say("started", 1);
  source.fail(2);
  await vi.waitFor(() => expect(waiting.length).toBe(1));
  waiting.pop()!();
  FakeSource.all[1]!.fail(2);
  await vi.waitFor(() => expect(seen).toEqual(["started 1", "failed 2"]));
  expect(waiting, "nobody asks again").toEqual([]);
  expect(FakeSource.all.length).toBe(2);
});
