// The tools, in the bar on the stage; the panel has what the one in the hand needs.
import { only } from "../store/store";
import { segmented } from "../ui/controls";
import type { Panel } from "../ui/Panel";
import type { DrawingActions } from "./actions";
import { type DrawingSlice, type Tool, TOOLS } from "./state";
import { drawing as words } from "./text";

export function createTools(drawing: DrawingActions): Panel<Pick<DrawingSlice, "drawn">> {
  const tools = segmented<Tool>(
    words.tools,
    TOOLS.map((value) => ({ value, label: words.toolNames[value], hint: words.toolHints[value] })),
    drawing.take,
  );
  return { element: tools.element, select: only("drawn"), update: ({ drawn }) => tools.set(drawn.tool) };
}
