// To the right, never hidden: what belongs to the open tab, and at its foot the one button that says what comes next.
import type { Step } from "../../store/page";
import { el, show } from "../../ui/dom";
import type { Panel } from "../../ui/Panel";
import { notice } from "../../ui/text";
import type { Session } from "../session";
import * as text from "../text";

/** `bodies`: what each tab has inside; `next`: the button below them all; `checks`: the tour and what is asked first, in their place while they last.  They follow the state by themselves. */
export function createSidePanel(bodies: Record<Step, HTMLElement>, next: HTMLElement, checks: readonly HTMLElement[]): Panel<Pick<Session, "step"> & { readonly scan: string }, Session> {
  const sections = (Object.keys(bodies) as Step[]).map((step) => ({ step, element: el("section", { class: "side-body", id: `side-${step}`, "aria-label": text.page.steps[step], hidden: true }, bodies[step]) }));
  const scroll = el("div", { class: "side-scroll" }, el("div", { class: "check-holder" }, ...checks), ...sections.map(({ element }) => element));
  scroll.addEventListener("toggle", ({ target }) => target instanceof HTMLDetailsElement && target.open && target.scrollIntoView({ block: "nearest" }), { capture: true }); // it does not bubble
  const element = el("aside", { class: "side", "aria-label": text.page.side }, scroll, el("div", { class: "side-foot" }, next, el("p", { class: "notice" }, notice)));
  let opened = "";
  return {
    element,
    select: ({ step, scan }) => ({ step, scan: scan?.info.id ?? "" }),
    update({ step, scan }): void {
      for (const { step: own, element: section } of sections) show(section, scan !== "" && own === step);
      if (opened !== `${scan} ${step}`) scroll.scrollTop = 0; // its head and what it asks first, not where another one was left
      opened = `${scan} ${step}`;
    },
  };
}
