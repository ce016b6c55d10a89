// What follows the pointer is brought up to date once a frame at most: pointers move more often than screens are drawn.

/** Calls `act` with the next frame, once however often it is asked for before. */
export function onceAFrame(act: () => void): () => void {
  let isAsked = false;
  return () => {
    if (isAsked) return;
    isAsked = true;
    requestAnimationFrame(() => {
      isAsked = false;
      act();
    });
  };
}
