// A panel whose code is loaded when it is wanted for the first time: what the first view does not show it need not wait for.
import { ApiError } from "../api/client";
import { noService } from "../api/text";
import { el } from "./dom";
import type { Panel } from "./Panel";

export function later<Shown extends object, State extends object = Shown>(
  select: (state: State) => Shown,
  isWanted: (shown: Shown) => boolean,
  load: () => Promise<Pick<Panel<Shown>, "element" | "update">>,
): Panel<Shown, State> {
  const element = el("div", {});
  let panel: Pick<Panel<Shown>, "element" | "update"> | null = null;
  let loading = false;
  let latest: Shown;

  async function begin(): Promise<void> {
    loading = true;
    try {
      panel = await load();
      element.append(panel.element);
      panel.update(latest);
    } catch {
      reportError(new ApiError(noService, 0)); // the page says it; the next change, such as one more click, tries again
    }
    loading = false;
  }

  return {
    element,
    select,
    update(shown: Shown): void {
      latest = shown;
      if (panel) panel.update(shown);
      else if (!loading && isWanted(shown)) void begin();
    },
  };
}
