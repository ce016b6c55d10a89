// The secret of a share link stands behind # only until the page has seen it: then the tab goes on to an address without it.
// It goes there by a navigation, because browsers keep every address that a navigation led to in the history that they list,
// but for one that only led on to another; an address that a script exchanges is listed all the same.  On the way the
// secret is in the name of the tab, which unlike all storage is never written to the disk.
const MARK = "breastrig-link:";

type Tab = Pick<Window, "name"> & { readonly location: Pick<Location, "hash" | "replace"> };

/** Whether there was a secret in the address; then this page is about to be left. */
export function passSecretOn(tab: Tab): boolean {
  const secret = tab.location.hash.slice(1);
  if (secret === "") return false;
  keepSecret(tab, secret);
  tab.location.replace("/s");
  return true;
}

/** For the next page of this tab. */
export function keepSecret(tab: Pick<Window, "name">, secret: string): void {
  if (secret !== "") tab.name = MARK + secret;
}

/** The secret that was passed on to this page, once; "" for none. */
export function takeSecret(tab: Pick<Window, "name">): string {
  if (!tab.name.startsWith(MARK)) return "";
  const secret = tab.name.slice(MARK.length);
  tab.name = "";
  return secret;
}
