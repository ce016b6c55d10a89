// Show this result to somebody: what the link shows, how long, behind which passcode; and the links made so far.
import { locale } from "../languages/words";
import type { Share, ShareRequest } from "../api/types";
import type { PageSlice } from "../store/page";
import { only } from "../store/store";
import { button, iconButton, problem, select } from "../ui/controls";
import { el, fill, icon, setText, show } from "../ui/dom";
import type { Panel } from "../ui/Panel";
import { close as closeText } from "../ui/text";
import type { ShareActions } from "./actions";
import type { ShareSlice } from "./state";
import * as text from "./text";

const DAYS = ["1", "7", "30", "90"] as const;
type Days = (typeof DAYS)[number];
const SHOWN = ["none", "plain", "full"] as const;
const words = text.share;
const moment = new Intl.DateTimeFormat(locale(), { day: "numeric", month: "short", hour: "2-digit", minute: "2-digit" });
const at = (iso: string): string => moment.format(new Date(iso));

type Shown = Pick<PageSlice & ShareSlice, "problems" | "share">;

export function createShareDialog(actions: ShareActions, dismiss: () => void): Panel<Shown> {
  let days: Days = "7";
  let scan: NonNullable<ShareRequest["scan"]> = "none";
  const expiry = select<Days>(words.expiry, (value) => (days = value));
  const shown = select<(typeof SHOWN)[number]>(words.shown, (value) => {
    scan = value;
    setText(showsWhat, words.showsWhat[value]);
  });
  const showsWhat = el("p", { class: "muted small", role: "status" }, words.showsWhat[scan]);
  const notes = el("input", { type: "checkbox" });
  const passcode = el("input", { type: "text", minlength: 6, maxlength: 100, autocomplete: "off", spellcheck: "false", placeholder: words.noPasscode });
  const make = el("button", { class: "button primary" }, el("span", {}, words.make));
  const busy = el("p", { class: "muted small", role: "status", hidden: true }, words.busy);
  const form = el(
    "form",
    {
      class: "share-form",
      onsubmit: (event) => {
        event.preventDefault();
        void actions.make({ expires_in_days: Number(days), scan, notes: notes.checked, passcode: passcode.value || null });
      },
    },
    el("div", { class: "share-choices" }, shown.element, expiry.element),
    showsWhat,
    el("label", { class: "check" }, notes, el("span", {}, words.withNotes)),
    el("label", { class: "field" }, el("span", {}, words.passcode), passcode),
    make,
    busy,
  );
  const address = el("input", { type: "text", readonly: true, id: "share-url", "aria-label": words.link, onfocus: () => address.select() });
  const copied = el("span", { class: "muted small", role: "status" });
  const copy = button(words.copy, () => void copyAddress(), "outlined");
  const made = el("div", { class: "share-made", hidden: true }, el("p", {}, words.once), el("div", { class: "share-url" }, address, copy), copied);
  const wrong = problem(dismiss);
  const list = el("ul", { class: "share-list" });
  const none = el("p", { class: "muted" }, words.none);
  const close = (): void => actions.close();
  const element = el(
    "dialog",
    { class: "help share", "aria-labelledby": "share-title", onclose: close },
    el("div", { class: "dialog-head" }, el("h2", { id: "share-title" }, words.title), iconButton("close", closeText, close)),
    el("p", { class: "muted" }, words.what),
    wrong.element,
    form,
    made,
    el("h3", {}, words.links),
    none,
    list,
  );
  // Escape goes through the state like any other way out; the browser's own closing is known only later.
  element.addEventListener("cancel", (event) => {
    event.preventDefault();
    close();
  });
  element.addEventListener("click", (event) => {
    if (event.target === element) close();
  });

  async function copyAddress(): Promise<void> {
    address.select();
    try {
      await navigator.clipboard.writeText(address.value);
      setText(copied, words.copied);
    } catch {
      setText(copied, words.copyByHand); // not allowed here: it is selected, and the keys work everywhere
    }
  }

  return {
    element,
    select: only("problems", "share"),
    update(state: Shown): void {
      const { share } = state;
      if (share.isOpen && !element.open) {
        passcode.value = "";
        notes.checked = false;
        element.showModal();
      }
      if (!share.isOpen && element.open) element.close();
      if (!share.isOpen) return;
      expiry.set(DAYS.map((value) => ({ value, label: words.days(Number(value)) })), days);
      shown.set(SHOWN.map((value) => ({ value, label: words.shows[value] })), scan);
      make.disabled = share.isBusy;
      show(busy, share.isBusy && share.list !== null); // what a link shows takes some seconds to be made
      wrong.set(state.problems.share);
      const url = share.made === null ? "" : new URL(share.made.url, location.origin).href;
      show(made, url !== "");
      if (address.value !== url) {
        address.value = url;
        setText(copied, "");
      }
      show(none, share.list?.length === 0);
      fill(list, share.list, () => (share.list ?? []).map((each) => row(each, actions)));
    },
  };
}

function row(share: Share, actions: ShareActions): HTMLElement {
  const isOver = share.revoked_at !== null || new Date(share.expires_at) <= new Date();
  const state = share.revoked_at ? words.revoked(at(share.revoked_at)) : isOver ? words.expired(at(share.expires_at)) : share.is_locked ? words.locked : words.until(at(share.expires_at));
  const opened = share.last_opened_at ? words.opened(share.openings, at(share.last_opened_at)) : words.neverOpened;
  const wrong = share.last_wrong_passcode_at ? el("p", { class: "muted small" }, words.wrong(share.wrong_passcodes, at(share.last_wrong_passcode_at))) : null;
  const facts = [words.shows[share.scan], ...(share.notes ? [words.hasNotes] : []), ...(share.has_passcode ? [words.hasPasscode] : [])].join(" · ");
  const shownAt = share.shown_at && !isOver ? el("p", { class: "muted small" }, words.shownAt(at(share.shown_at))) : null;
  return el(
    "li",
    { class: isOver ? "is-over" : "" },
    icon(share.is_open ? "link" : "close"),
    el("div", {}, el("p", {}, state), el("p", { class: "muted small" }, facts), shownAt, el("p", { class: "muted small" }, opened), wrong),
    share.is_locked && !isOver ? button(words.unlock, () => void actions.unlock(share.links.unlock), "quiet outlined") : null,
    !isOver ? button(words.refresh, () => void actions.refresh(share.links.refresh), "quiet outlined") : null,
    !isOver ? button(words.revoke, () => void actions.revoke(share.links.self), "quiet outlined") : null,
  );
}
