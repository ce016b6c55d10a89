// A fit's events as they come: typed, in order, each once, whatever the connection does.
// EventSource resumes by itself after a break; when it gives up (the service answered with an error), we open a
// new one after a while and ask for the events after the last that we saw; unless the fit is gone, which is its end.
import type { Done, Ended, Iterated, Started } from "./types";

interface Bodies {
  started: Started;
  iterated: Iterated;
  done: Done;
  failed: Ended;
  cancelled: Ended;
}

export type Kind = keyof Bodies;
export type FitEvent<K extends Kind = Kind> = { [P in K]: { kind: P; id: number; body: Bodies[P] } }[K];
/** A missing kind does not compile. */
export type Handlers = { [K in Kind]: (event: FitEvent<K>) => void };

export function dispatch<K extends Kind>(handlers: Handlers, event: FitEvent<K>): void {
  handlers[event.kind](event);
}

const IS_LAST: Record<Kind, boolean> = { started: false, iterated: false, done: true, failed: true, cancelled: true };
const KINDS = Object.keys(IS_LAST) as Kind[];
const PATIENCE_MS = 2000;
const CLOSED = 2; // EventSource.CLOSED, which does not exist where the unit tests run

export interface Source {
  readonly readyState: number;
  onopen: ((event: Event) => void) | null;
  onerror: ((event: Event) => void) | null;
  addEventListener(kind: string, listener: (event: MessageEvent<string>) => void): void;
  close(): void;
}

export interface Following {
  handlers: Handlers;
  onConnection?: (isConnected: boolean) => void;
  /** Asked when the service refuses: why nothing more will come, as a sentence; null where it may. */
  whyOver?: () => Promise<string | null>;
  open?: (url: string) => Source;
  later?: (action: () => void, milliseconds: number) => void;
}

/** Follows the events behind `url` until the last; the returned function stops at once. */
export function followFit(url: string, following: Following): () => void {
  const open: (address: string) => Source = following.open ?? ((address) => new EventSource(address));
  const later = following.later ?? ((action, ms) => void setTimeout(action, ms));
  let seen = 0;
  let isOver = false;
  let source: Source | null = null;

  const stop = (): void => {
    isOver = true;
    source?.close();
  };

  const connect = (): void => {
    if (isOver) return;
    const current = open(seen === 0 ? url : `${url}?after=${seen}`);
    source = current;
    current.onopen = () => following.onConnection?.(true);
    current.onerror = () => {
      if (isOver) return;
      following.onConnection?.(false);
      if (current.readyState !== CLOSED) return; // it tries again by itself
      current.close();
      if (!following.whyOver) return later(connect, PATIENCE_MS);
      void following.whyOver().then((reason) => {
        if (isOver) return;
        if (reason === null) return later(connect, PATIENCE_MS);
        stop();
        following.handlers.failed({ kind: "failed", id: seen + 1, body: { reason } });
      });
    };
    for (const kind of KINDS) current.addEventListener(kind, (message) => receive(kind, message));
  };

  const receive = (kind: Kind, message: MessageEvent<string>): void => {
    const id = Number(message.lastEventId);
    if (isOver || id <= seen) return; // sent again after a reconnection
    seen = id;
    if (IS_LAST[kind]) stop();
    dispatch(following.handlers, { kind, id, body: JSON.parse(message.data) as Bodies[Kind] } as FitEvent);
  };

  connect();
  return stop;
}
