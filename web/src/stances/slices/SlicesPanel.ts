// Slices through the scan's skin in three planes, beside the body: one cross in all of them, moved by hand, by keys and by the
// sliders.  What is drawn is what is known: the skin's section, the body flat or as its image has it, lesions and planned lines.
// Loaded when opened.
import type { Frame, Scan, Vector } from "../../api/types";
import { lineNear, ballCut, bodyOf, cut, flat, type Flat, placeAt, type View, viewOf } from "../../drawing/slices/section";
import { areSlicesOpen, initialSlices, type Plane, PLANES } from "../../drawing/slices/state";
import { alongSlice } from "../../drawing/lesions/slices";
import { button, iconButton, segmented } from "../../ui/controls";
import { el, setText, show, svg } from "../../ui/dom";
import { dot, leftOf } from "../../viewer/frame";
import { onceAFrame } from "../../viewer/onceAFrame";
import { view as viewText } from "../../viewer/text";
import { createGreySlices, type SeenAt } from "./GreySlices";
import { createLesionHand, type LesionActions } from "./lesionHand";
import { besideMiddle, bodyBeside, crossOf, frameOf, isSliced, lesionsIn, linesIn, type SeenLesion, slicedOf, type SlicesShown } from "./shown";
import { boxOf, fromWays, readSkin, type SeenSkin } from "./skinOf";
import { hand as handWords, slices as words } from "./text";
import "./slices.css";

export interface SlicesActions extends LesionActions {
  readonly volume: (scan: Scan) => Promise<ArrayBuffer>;
}

const STEP_MM = { key: 1, withShift: 5 };
const KEYS: Readonly<Record<string, readonly [right: number, up: number, out: number]>> = { ArrowLeft: [-1, 0, 0], ArrowRight: [1, 0, 0], ArrowUp: [0, 1, 0], ArrowDown: [0, -1, 0] };
const PAGES: Readonly<Record<string, number>> = { PageUp: 1, PageDown: -1 };
const TAP_PX = 4;
const HANDLE = { seen: 5, reach: 14, away: 11 }; // px, beside the edge
const TWICE = { ms: 350, px: 24 }; // two taps on one place
const MOST_MM = 360; // of a scan that is seen at once: of a whole body a lesion would be a dot
const AIR = 1.1; // around it
const LINE_HALF = 1; // mm beside the plane that a line is still seen
const SCALES_CM = [1, 2, 5, 10];
const SCALE_PX = 90;
const SAY_MS = 500; // after the last key
const ZOOM = { most: 12, key: 1.25, pixel: 1.01, notch: 30 }; // times as large as the whole; by a key; by a pixel of two fingers on a pad, of which a wheel's notch counts so many
const PHONE = "(width < 560px), (width < 900px) and (height < 560px)"; // as ui/layout.css has it

const AXIS: Readonly<Record<Plane, 0 | 1 | 2>> = { sagittal: 0, axial: 1, coronal: 2 }; // of left, up, front: along which it is moved
const apart = (a: Vector, b: Vector): number => Math.hypot(...a.map((value, k) => value - b[k]!));
const waysOf = (at: Vector, frame: Frame): Vector => [dot(at, leftOf(frame)), dot(at, frame.up), dot(at, frame.front)];
const named = ([left, up, front]: Vector) => ({ left, up, front });
const pathOf = (lines: readonly (readonly Flat[])[], end: string): string => lines.map((points) => points.map(([x, y], i) => `${i === 0 ? "M" : "L"}${x.toFixed(1)} ${(-y).toFixed(1)}`).join("") + end).join("");

export function createSlices(actions: SlicesActions) {
  let state: SlicesShown;
  let skin: SeenSkin | null = null;
  let read: { readonly bytes: ArrayBuffer; readonly frame: Frame } | null = null;
  let middle: Vector = [0, 0, 0]; // of what is seen: left, up, front; mm
  let held: Vector | null = null; // where the hand has the cross just now
  let zoom = 1; // of all slices alike
  let followed = ""; // the cross that the picture has followed
  const phone = matchMedia(PHONE);
  const said = el("p", { class: "visually-hidden", role: "status" });
  let saying: ReturnType<typeof setTimeout> | undefined;

  const pick = segmented<Plane | "body">(words.group, [...PLANES, "body" as const].map((value) => ({ value, label: words.names[value] })), (enlarged) => actions.slices({ enlarged }));
  const all = button(words.all, () => actions.slices({ enlarged: null }), "outlined");
  const close = iconButton("close", words.close, () => leave());
  const body = iconButton("expand", words.enlarge(words.names.body), () => actions.slices({ enlarged: "body" }));
  const unseen = el("p", { class: "slices-unseen muted", hidden: true }, words.unseen);
  const moving = el("p", { class: "slices-moving small", role: "status", hidden: true });
  const coming = el("p", { class: "slices-unseen small", role: "status", hidden: true });
  const mark = button(handWords.mark, () => hand.begin(), "quiet");
  mark.title = handWords.markHint;
  const grey = createGreySlices(actions.volume, () => draw(), (sentence) => {
    setText(coming, sentence);
    show(coming, sentence !== "");
  });
  const head = el("div", { class: "slices-head" }, pick.element, all, el("span", { class: "spring" }));
  const panes = PLANES.map((plane) => createPane(plane));
  const element = el("div", { class: "slices", hidden: true }, head, ...panes.map((pane) => pane.element), el("div", { class: "slices-body" }, body), el("div", { class: "slices-close" }, close), el("div", { class: "slices-tools" }, mark, grey.control), moving, unseen, coming, said);

  const leave = (): void => (state.slices.enlarged && !phone.matches ? actions.slices({ enlarged: null }) : actions.slices(initialSlices));
  const draw = onceAFrame(() => isSliced(state) && drawAll());
  phone.addEventListener("change", () => update(state));
  const resized = new ResizeObserver(draw);
  for (const pane of panes) resized.observe(pane.picture);

  const hand = createLesionHand(actions, () => state, () => draw());
  const cross = (): Vector => held ?? crossOf(state, slicedOf(state).of) ?? [0, 0, 0];

  /** The cross goes there; with a lesion in the hand, so does that, once the hand lets go. */
  function go(at: Vector, isOver = true): void {
    const { scan } = slicedOf(state).of;
    if (!scan) return;
    const rounded = at.map((value) => Math.round(10 * value) / 10) as unknown as Vector;
    held = isOver ? null : rounded;
    actions.slices({ cross: { scan: scan.info.id, at: rounded } });
    if (isOver) hand.moved(rounded);
  }

  /** So many times larger, around a place that stays where it is seen. */
  function zoomAt(place: Vector, times: number): void {
    const now = Math.min(Math.max(zoom * times, 1), ZOOM.most);
    const around = waysOf(place, frameOf(slicedOf(state).of.scan!));
    middle = middle.map((was, k) => around[k]! + (was - around[k]!) * (zoom / now)) as unknown as Vector;
    zoom = now;
    if (zoom === 1) followed = ""; // the whole again
    draw();
  }

  function say(): void {
    clearTimeout(saying);
    saying = setTimeout(() => setText(said, placeWords()), SAY_MS);
  }

  function placeWords(): string {
    const { of } = slicedOf(state);
    const at = cross();
    const nearest = lesionsIn(of).map((each) => ({ each, mm: apart(each.center, at) })).sort((a, b) => a.mm - b.mm)[0];
    const lesion = !nearest ? "" : nearest.mm <= nearest.each.radius ? words.inLesion(nearest.each.name) : words.nearLesion(nearest.each.name, nearest.mm);
    return words.place(named(waysOf(at, frameOf(of.scan!))), lesion);
  }

  function createPane(plane: Plane) {
    const body = svg("path", { class: "slice-body" });
    const lines = { skin: outlined("slice-skin"), fitted: outlined("slice-fitted"), wall: outlined("slice-wall"), plan: outlined("slice-line"), cross: outlined("slice-cross") };
    const balls = svg("g", {});
    const picture = svg("svg", { tabindex: 0, role: "img", class: "slice-picture" }, body, ...lines.skin.both, ...lines.fitted.both, ...lines.wall.both, ...lines.plan.both, ...lines.cross.both, balls);
    const image = grey.pane(picture);
    const side = el("span", {});
    const at = el("span", { class: "slice-at" });
    const slider = el("input", { type: "range", class: "slice-slider", step: 1, "aria-label": words.through(words.names[plane]), oninput: () => { goAlong(slider.valueAsNumber); say(); } });
    const scale = el("div", { class: "scale-bar" }, el("span", {}));
    const edges = Object.entries(words.edges[plane]).map(([edge, name]) => el("span", { class: `slice-edge is-${edge}${name === "L" ? " mark side-left" : name === "R" ? " mark side-right" : ""}`, "aria-hidden": "true" }, name));
    const element = el("section", { class: `slice is-${plane}`, "aria-label": words.names[plane] }, image.element, picture, ...edges, el("p", { class: "slice-title" }, el("strong", {}, words.names[plane]), side, at), iconButton("expand", words.enlarge(words.names[plane]), () => enlarge()), slider, scale);
    let tapped = { at: 0, x: 0, y: 0 };

    const enlarge = (): void => actions.slices({ enlarged: state.slices.enlarged === plane ? null : plane });
    const frame = (): Frame => frameOf(slicedOf(state).of.scan!);
    const view = (): View => viewOf(plane, frame());
    let seen: SeenAt = { mm: 1, middle: [0, 0], width: 0, height: 0 };

    function goAlong(value: number): void {
      const ways = [...waysOf(cross(), frame())];
      ways[AXIS[plane]] = value;
      go(fromWays(ways, frame()));
    }

    picture.addEventListener("keydown", (event) => {
      const { key, shiftKey, ctrlKey, metaKey, altKey } = event;
      if (ctrlKey || metaKey || altKey) return;
      const step = shiftKey ? STEP_MM.withShift : STEP_MM.key;
      const ways = waysOf(cross(), frame());
      if (hand.key(event, cross())) draw();
      else if (KEYS[key]) {
        const { right, up } = view();
        go(cross().map((value, k) => value + step * (KEYS[key]![0] * right[k]! + KEYS[key]![1] * up[k]!)) as unknown as Vector);
      } else if (PAGES[key]) goAlong(ways[AXIS[plane]] + step * PAGES[key]);
      else if (key === "+" || key === "=") zoomAt(cross(), ZOOM.key);
      else if (key === "-") zoomAt(cross(), 1 / ZOOM.key);
      else if (key === "Enter") enlarge();
      else if (key === "Escape") leave();
      else if (!grey.key(event)) return;
      say();
      event.preventDefault();
      event.stopPropagation();
    });
    picture.addEventListener("wheel", (event) => {
      if (event.deltaY === 0) return;
      event.preventDefault();
      if (event.ctrlKey || event.metaKey) zoomAt(pointed(event), ZOOM.pixel ** Math.min(Math.max(-event.deltaY, -ZOOM.notch), ZOOM.notch));
      else goAlong(waysOf(cross(), frame())[AXIS[plane]] + (event.deltaY < 0 ? 1 : -1));
    });
    const pointed = (event: Pick<PointerEvent, "clientX" | "clientY">): Vector => {
      const box = picture.getBoundingClientRect();
      const [x, y] = [event.clientX - box.left - box.width / 2, event.clientY - box.top - box.height / 2];
      return placeAt([seen.middle[0] + x * seen.mm, seen.middle[1] - y * seen.mm], view(), cross());
    };
    let handle: Flat | null = null; // on the edge of the lesion in the hand
    const isOnHandle = (event: PointerEvent): boolean => {
      const at = flat(pointed(event), view());
      return handle !== null && Math.hypot(at[0] - handle[0], at[1] - handle[1]) < HANDLE.reach * seen.mm;
    };
    const fingers = new Map<number, PointerEvent>();
    const spread = (): { readonly apart: number; readonly at: Vector } => {
      const [a, b] = [...fingers.values()] as [PointerEvent, PointerEvent];
      return { apart: Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY), at: pointed({ clientX: (a.clientX + b.clientX) / 2, clientY: (a.clientY + b.clientY) / 2 }) };
    };
    picture.addEventListener("pointermove", (event) => {
      if (!fingers.has(event.pointerId)) {
        hand.hover(pointed(event));
        return;
      }
      const before = fingers.size === 2 ? spread().apart : 0;
      fingers.set(event.pointerId, event);
      if (fingers.size === 2 && before > 0) zoomAt(spread().at, spread().apart / before);
    });
    for (const type of ["pointerup", "pointercancel"] as const) picture.addEventListener(type, ({ pointerId }) => fingers.delete(pointerId));
    picture.addEventListener("pointerleave", () => hand.hover(null));
    picture.addEventListener("pointerdown", (event) => {
      if (event.button !== 0 || !skin) return;
      fingers.set(event.pointerId, event);
      if (!event.isPrimary) {
        picture.setPointerCapture(event.pointerId);
        picture.dispatchEvent(new PointerEvent("pointercancel", { pointerId: -1 })); // two fingers zoom: the first one moves nothing
        return;
      }
      const isTwice = !hand.isMarking() && event.timeStamp - tapped.at < TWICE.ms && Math.hypot(event.clientX - tapped.x, event.clientY - tapped.y) < TWICE.px;
      tapped = isTwice ? { at: 0, x: 0, y: 0 } : { at: event.timeStamp, x: event.clientX, y: event.clientY };
      if (isTwice) {
        enlarge();
        return;
      }
      picture.focus({ preventScroll: true });
      event.preventDefault(); // no text is chosen while it is dragged
      picture.setPointerCapture(event.pointerId);
      const from = pointed(event);
      const start = cross();
      const held = hand.held();
      const isSized = held !== null && isOnHandle(event);
      let isTap = hand.isMarking(); // until it is dragged: then it moves the cross, to find the place
      const to = (now: PointerEvent): Vector => (held ? (start.map((value, k) => value + pointed(now)[k]! - from[k]!) as unknown as Vector) : pointed(now)); // a tap beside it is no wish to move it there
      const step = (now: PointerEvent, isOver: boolean): void => {
        if (isOver && isTap) hand.tap(pointed(now));
        else if (isSized) hand.resize(held.radius + apart(pointed(now), start) - apart(from, start), isOver);
        else go(to(now), isOver);
      };
      if (!isTap) step(event, false);
      const over = new AbortController();
      const end = (now: PointerEvent): void => {
        over.abort();
        if (now.type !== "pointercancel") step(now, true);
        else if (isSized) hand.resize(held.radius, true);
        else if (!hand.isMarking() || !isTap) go(start);
        say();
      };
      picture.addEventListener("pointermove", (now) => {
        isTap &&= Math.hypot(now.clientX - event.clientX, now.clientY - event.clientY) < TAP_PX;
        if (!isTap) step(now, false);
      }, over);
      for (const type of ["pointerup", "pointercancel"] as const) picture.addEventListener(type, end, over);
    });

    let cutAs = ""; // the section is the same while only lines or the cross in it change
    let cutOf: SeenSkin | null = null;

    return {
      plane,
      element,
      picture,
      release: image.release,
      draw(mm: number): void {
        picture.setAttribute("aria-label", words.picture(words.names[plane], grey.isThere()));
        const { of } = slicedOf(state);
        if (!of.scan || !skin) return;
        const through = cross();
        const now = view();
        const offset = dot(through, now.out);
        const { width, height } = picture.getBoundingClientRect();
        if (width === 0) return;
        seen = { mm, middle: flat(fromWays(middle, frame()), now), width, height };
        const [cx, cy] = seen.middle;
        picture.setAttribute("viewBox", [cx - (mm * width) / 2, -cy - (mm * height) / 2, mm * width, mm * height].map((value) => value.toFixed(2)).join(" "));
        const key = JSON.stringify([offset.toFixed(2), frame()]);
        if (key !== cutAs || cutOf !== skin) {
          [cutAs, cutOf] = [key, skin];
          const outlines = cut(skin, now, offset);
          lines.skin.set(outlines.map(({ points, isClosed }) => pathOf([points], isClosed ? "Z" : "")).join(""));
          body.setAttribute("d", pathOf(bodyOf(outlines, boxOf(skin, frame(), now)) ?? [], "Z"));
        }
        image.draw(now, offset, seen);
        lines.plan.set(pathOf(linesIn(of).flatMap((points) => lineNear(points, now, offset, LINE_HALF)), ""));
        const inHand = hand.held();
        const sketch = hand.sketch();
        const lesions = [...lesionsIn(of).map((each) => (each.id === inHand?.id ? { ...inHand, center: through } : each)), ...(sketch ? [sketch] : [])];
        handle = inHand && [flat(through, now)[0] + inHand.radius + HANDLE.away * mm, flat(through, now)[1]];
        balls.replaceChildren(...lesions.flatMap((each) => ballsOf(each, now, offset, each.id === state.lesion)), ...(handle ? [svg("circle", { cx: handle[0], cy: -handle[1], r: HANDLE.seen * mm, class: "slice-handle" })] : []));
        const chosen = lesions.filter(({ id }) => id === state.lesion);
        for (const [name, path] of [["outlines_mm", lines.fitted], ["wall_mm", lines.wall]] as const) path.set(chosen.map((each) => modelIn(each, name, plane, now, offset)).join(""));
        const [x, y] = flat(through, now);
        const far = mm * (width + height);
        lines.cross.set(`M${x - far} ${-y}H${x + far}M${x} ${-y - far}V${-y + far}`);
        const ways = waysOf(through, frame());
        const away = plane === "sagittal" ? besideMiddle(through, of, frame()) : null;
        setText(side, away === null ? "" : words.side(away));
        setText(at, words.at(plane, named(ways)));
        const axis = AXIS[plane];
        slider.min = String(Math.floor(skin.low[axis]));
        slider.max = String(Math.ceil(skin.high[axis]));
        slider.value = String(Math.round(ways[axis]));
        slider.setAttribute("aria-valuetext", words.at(plane, named(ways)));
        const cm = SCALES_CM.findLast((length) => (10 * length) / mm <= SCALE_PX) ?? SCALES_CM[0]!;
        scale.style.width = `${((10 * cm) / mm).toFixed(1)}px`;
        setText(scale.firstElementChild!, viewText.scale(cm));
      },
    };
  }

  function drawAll(): void {
    const { of } = slicedOf(state);
    if (!of.scan || !skin) return;
    const spans = skin.low.map((low, k) => Math.min(skin!.high[k]! - low, MOST_MM) / zoom);
    const ways = waysOf(cross(), frameOf(of.scan));
    const key = JSON.stringify(ways);
    if (held === null && key !== followed) middle = middle.map((was, k) => middleOf(was, ways[k]!, spans[k]!, skin!.low[k]!, skin!.high[k]!)) as unknown as Vector;
    if (held === null) followed = key;
    const [left, up, front] = spans as [number, number, number];
    const boxes = panes.map(({ plane, picture }) => ({ box: picture.getBoundingClientRect(), across: plane === "sagittal" ? front : left, high: plane === "axial" ? front : up })).filter(({ box }) => box.width > 0);
    const mm = AIR * Math.max(...boxes.map(({ box, across, high }) => Math.max(across / box.width, high / box.height))); // one for all
    element.classList.toggle("has-image", grey.isThere());
    for (const pane of panes) pane.draw(mm);
  }

  function load(): void {
    const { scan } = slicedOf(state).of;
    const bytes = scan?.mesh ?? null;
    const frame = scan && frameOf(scan);
    show(unseen, bytes === null);
    grey.follow(scan?.info ?? null);
    if (!bytes || !frame || (read?.bytes === bytes && read.frame === frame)) return;
    const mine = (read = { bytes, frame });
    skin = null;
    void readSkin(bytes, frame).then(
      (now) => {
        if (read !== mine) return;
        skin = now;
        zoom = 1;
        followed = "";
        middle = now.low.map((low, k) => (low + now.high[k]!) / 2) as unknown as Vector;
        if (crossOf(state, slicedOf(state).of) === null) go(fromWays(middle, frame));
        draw();
      },
      () => read === mine && show(unseen, true),
    );
  }

  function update(now: SlicesShown): void {
    state = now;
    const isOn = isSliced(now);
    show(element, isOn);
    const stages = element.closest<HTMLElement>(".stages");
    stages?.classList.toggle("is-sliced", isOn);
    const one = isOn ? (now.slices.enlarged ?? (phone.matches ? "axial" : null)) : null;
    if (stages) stages.dataset.pane = one ?? "all";
    if (stages) stages.dataset.body = isOn ? bodyBeside(now) : "";
    if (!areSlicesOpen(now)) {
      grey.follow(null);
      for (const pane of panes) pane.release();
    }
    if (!isOn) return;
    pick.set(one);
    show(all, !phone.matches);
    setText(moving, hand.says());
    show(moving, moving.textContent !== "");
    show(mark, now.scan?.info.image != null && slicedOf(now).isMain && !hand.isMarking());
    load();
    draw();
  }

  return { element, update };
}

/** A line with another one below it that parts it from whatever is there. */
function outlined(look: string) {
  const both = [svg("path", { class: `${look}-under` }), svg("path", { class: look })] as const;
  return { both, set: (d: string): void => both.forEach((path) => path.setAttribute("d", d)) };
}

/** The picture stays where it is while the cross is well inside. */
function middleOf(was: number, cross: number, span: number, low: number, high: number): number {
  if (high - low <= span) return (low + high) / 2;
  return Math.abs(cross - was) < 0.4 * span ? was : Math.min(Math.max(cross, low + span / 2), high - span / 2);
}

function ballsOf({ center, radius, reach }: SeenLesion, view: View, offset: number, isChosen: boolean): SVGElement[] {
  const [x, y] = flat(center, view);
  const circle = (r: number | null, look: string): SVGElement[] => (r === null ? [] : [svg("circle", { cx: x.toFixed(2), cy: (-y).toFixed(2), r: r.toFixed(2), class: look })]);
  const cut = ballCut(center, radius, view, offset);
  return [...circle(reach === null ? null : ballCut(center, reach, view, offset), "slice-reach"), ...circle(cut, "slice-ball-under"), ...circle(cut, `slice-ball${isChosen ? " is-chosen" : ""}`)];
}

const SAME_MM = 0.5;

/** Skin or chest wall as the model has them, which the service says for the planes through the lesion's centre. */
function modelIn({ center, laid }: SeenLesion, of: "outlines_mm" | "wall_mm", plane: Plane, view: View, offset: number): string {
  const slice = laid?.slices.find((each) => each.plane === plane);
  if (!slice || Math.abs(dot(center, view.out) - offset) > SAME_MM) return "";
  const [x, y] = flat(center, view);
  const [rx, ux] = alongSlice([0, 0, 0], view.right, slice);
  const [ry, uy] = alongSlice([0, 0, 0], view.up, slice);
  return pathOf(slice[of].map((points) => points.map(([a, b]): Flat => [x + a * rx + b * ux, y + a * ry + b * uy])), "");
}
