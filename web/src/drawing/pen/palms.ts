// A tablet with a stylus: once a pen was seen, fingers turn the body, until somebody wants them to draw again; and what touches the
// glass while the pen is on it is the hand that holds it, until it is lifted.  Pressure is not looked at: a marker's line
// is as wide as it is.

export class Palms {
  /** A pen has come near in this page. */
  hasPen = false;
  /** Wished for, though there is a pen: it may be empty or lie elsewhere. */
  fingersDraw = false;
  private pen: number | null = null; // on the glass
  private readonly touches = new Set<number>();
  private readonly palms = new Set<number>();

  /** A pointer is put down; false: it is a palm, and means nothing. */
  down(id: number, kind: string): boolean {
    if (kind === "pen") {
      this.hasPen = true;
      this.pen = id;
      for (const touch of this.touches) this.palms.add(touch); // the hand comes down before its pen does
      return true;
    }
    if (kind !== "touch") return true;
    this.touches.add(id);
    if (this.pen !== null) this.palms.add(id);
    return this.pen === null;
  }

  /** False: a palm's. */
  move(id: number, kind: string): boolean {
    if (kind === "pen") this.hasPen = true; // it hovers
    return !this.palms.has(id);
  }

  up(id: number): void {
    if (this.pen === id) this.pen = null;
    this.touches.delete(id);
    this.palms.delete(id);
  }

  get isPenDown(): boolean {
    return this.pen !== null;
  }

  /** Fingers turn the body with whatever tool. */
  get areFingersFree(): boolean {
    return this.hasPen && !this.fingersDraw;
  }

  mayDraw = (kind: string): boolean => !(kind === "touch" && this.areFingersFree);
}

/**
 * Before anybody else hears of a pointer on this canvas: palms are kept from all.  `changed` is called when a pen is first
 * seen, and when it comes down or is lifted.
 */
export function rejectPalms(canvas: HTMLElement, isDrawing: () => boolean, changed: (palms: Palms) => void): Palms {
  const palms = new Palms();
  const telling = (what: () => void): void => {
    const before = [palms.hasPen, palms.isPenDown];
    what();
    if (before[0] !== palms.hasPen || before[1] !== palms.isPenDown) changed(palms);
  };
  const first = { capture: true };
  canvas.addEventListener("pointerdown", (event) => {
    telling(() => {
      const isMeant = palms.down(event.pointerId, event.pointerType);
      if (!isMeant && isDrawing()) event.stopImmediatePropagation();
    });
  }, first);
  canvas.addEventListener("pointermove", (event) => {
    telling(() => {
      if (!palms.move(event.pointerId, event.pointerType) && isDrawing()) event.stopImmediatePropagation();
    });
  }, first);
  for (const kind of ["pointerup", "pointercancel"] as const) canvas.addEventListener(kind, (event) => telling(() => palms.up(event.pointerId)), first);
  return palms;
}
