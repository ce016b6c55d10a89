// What a person has changed on a scan and the service does not have yet.  It waits in this tab's own memory, which outlives a
// reload and the sign-in page and ends with the tab; each room keeps there what it needs to save its part later.
import { ApiError } from "../api/client";

export type Unsaved = "landmarks" | "lines" | "cuts"; // lines: all of the plan

type Memory = Pick<Storage, "getItem" | "setItem" | "removeItem" | "key" | "length">;

const PREFIX = "breastrig.unsaved/";
const OWNER = "breastrig.person"; // the person who has typed it
const OTHERS = "breastrig.others-unsaved/"; // of persons who were here before

/** Trying again later can help: nobody answers, the session is over, the service is busy or its disk full. */
const mayPass = (error: unknown): boolean => !(error instanceof ApiError) || error.status === 0 || error.status >= 500 || [401, 408, 412, 429].includes(error.status);

const isGone = (error: unknown): boolean => error instanceof ApiError && (error.status === 404 || error.status === 410);

interface Entry {
  readonly patient: string;
  readonly value: unknown;
}

/** What could not be saved when it was tried last. */
export interface Refused {
  readonly what: readonly Unsaved[];
  readonly why: string;
  readonly mayPass: boolean;
}

export function createOutbox(memory: Memory | null = null) {
  const entries = new Map<string, Entry>(); // "lines/ID OF THE SCAN"
  const refused = new Map<string, unknown>();
  const followers: (() => void)[] = [];
  let isTold = true;
  let isFull = false; // the browser keeps no more: only the open page has it

  const keyOf = (what: Unsaved, scan: string): string => `${what}/${scan}`;
  const whatOf = (key: string): Unsaved => key.slice(0, key.indexOf("/")) as Unsaved;

  /** Soon: who follows may set the state, which a listener of the state may not. */
  function tell(): void {
    if (!isTold) return;
    isTold = false;
    queueMicrotask(() => {
      isTold = true;
      for (const follow of followers) follow();
    });
  }

  function write(key: string, entry: Entry): void {
    entries.set(key, entry);
    try {
      memory?.setItem(PREFIX + key, JSON.stringify(entry));
      isFull = false;
    } catch {
      memory?.removeItem(PREFIX + key);
      isFull = true;
    }
  }

  function remove(key: string): void {
    if (!entries.delete(key)) return;
    refused.delete(key);
    memory?.removeItem(PREFIX + key);
    tell();
  }

  function load(from: Memory): void {
    const keys = Array.from({ length: from.length }, (_, i) => from.key(i) ?? "").filter((key) => key.startsWith(PREFIX));
    for (const key of keys) {
      try {
        entries.set(key.slice(PREFIX.length), JSON.parse(from.getItem(key) ?? "") as Entry);
      } catch {
        from.removeItem(key);
      }
    }
  }
  if (memory) load(memory);

  /** Moves what the browser keeps to other names. */
  function rename(from: string, to: string): void {
    const keys = Array.from({ length: memory?.length ?? 0 }, (_, i) => memory?.key(i) ?? "").filter((key) => key.startsWith(from));
    for (const key of keys) {
      memory?.setItem(to + key.slice(from.length), memory.getItem(key) ?? "");
      memory?.removeItem(key);
    }
  }

  return {
    /** It is this person's from now on; what another one could not save waits for that one.  Whether somebody else was here before. */
    belongTo(person: string): boolean {
      const before = memory?.getItem(OWNER) ?? person;
      memory?.setItem(OWNER, person);
      if (before === person) return false;
      rename(PREFIX, `${OTHERS}${before}/`);
      rename(`${OTHERS}${person}/`, PREFIX);
      entries.clear();
      refused.clear();
      if (memory) load(memory);
      tell();
      return true;
    },
    keep: (what: Unsaved, scan: string, patient: string, value: unknown): void => write(keyOf(what, scan), { patient, value }),
    /** As its room has kept it; null where nothing waits. */
    kept: (what: Unsaved, scan: string): unknown => entries.get(keyOf(what, scan))?.value ?? null,
    /** The service has it. */
    saved: (what: Unsaved, scan: string): void => remove(keyOf(what, scan)),
    /** It could not be saved; what belongs to a scan that is gone is forgotten. */
    failed(what: Unsaved, scan: string, error: unknown): void {
      const key = keyOf(what, scan);
      if (isGone(error)) return remove(key);
      if (entries.has(key)) refused.set(key, error);
      tell();
    },
    /** Scans of which something waits. */
    scans: (what: Unsaved): string[] => [...entries.keys()].filter((key) => whatOf(key) === what).map((key) => key.slice(what.length + 1)),
    /** Nobody wants it any more: its scan or its patient is deleted, or was left without saving. */
    forget(is: (scan: string, patient: string) => boolean): void {
      for (const [key, { patient }] of [...entries]) if (is(key.slice(key.indexOf("/") + 1), patient)) remove(key);
    },
    refused(): Refused | null {
      const errors = [...refused.values()];
      if (errors.length === 0) return null;
      const last = errors.at(-1);
      return { what: [...new Set([...refused.keys()].map(whatOf))], why: last instanceof Error ? last.message : String(last), mayPass: errors.some(mayPass) };
    },
    isFull: (): boolean => isFull,
    /** Called soon after something was refused or saved. */
    follow: (follower: () => void): void => void followers.push(follower),
  };
}

export type Outbox = ReturnType<typeof createOutbox>;
