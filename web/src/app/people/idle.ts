// Whether somebody is at the page.  The service ends a session that nobody has kept for a while; asking it for things is not being there.
import { people as words } from "./text";

const KEY = "breastrig.at-page"; // for all tabs of this browser: when somebody moved in one of them
const EACH_MS = 60_000; // so often at most the service hears of it
const WARNED_MS = 60_000; // before the end
const LOOK_MS = 5_000;
const MOVES = ["pointerdown", "pointermove", "keydown", "wheel", "touchstart"] as const;

interface Idle {
  readonly minutes: number;
  readonly memory: Pick<Storage, "getItem" | "setItem">;
  readonly stay: () => Promise<void>;
  /** Null: it is not to be said any more. */
  readonly warn: (sentence: string | null) => void;
  /** Nobody was there for so long: the page gives way to the sign-in. */
  readonly leave: () => void;
}

export function followIdle({ minutes, memory, stay, warn, leave }: Idle, on: Pick<Window, "addEventListener" | "setInterval"> = window, now = (): number => Date.now()): void {
  let said = now(); // the page has just been let in
  let isWarned = false;
  const moved = (): void => {
    memory.setItem(KEY, String(now()));
    if (isWarned) warn(null);
    isWarned = false;
    if (now() - said < EACH_MS) return;
    said = now();
    void stay().catch(() => undefined); // a session that is over leads to the sign-in by itself
  };
  memory.setItem(KEY, String(now()));
  for (const move of MOVES) on.addEventListener(move, moved, { capture: true, passive: true });
  on.setInterval(() => {
    const left = Number(memory.getItem(KEY)) + 60_000 * minutes - now();
    if (left <= 0) leave();
    else if (left <= WARNED_MS && !isWarned) {
      isWarned = true;
      warn(words.soonOver);
    }
  }, LOOK_MS);
}
