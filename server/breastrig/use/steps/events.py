"""The events of a fit, in order: started, iterated … (none of a prediction), then exactly one of done, failed,
cancelled.

They are the only record of its course: stored first, then sent, replayed from any number.  `nodes` speaks
glTF's own words, so that the page applies an event and a .gltf file with the same code.
"""

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from breastrig.core.stances import Stance
from breastrig.files.result import DoubtedPick, ResultFile


class EventPart(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)


class Event(EventPart):
    kind: str


class NodePose(EventPart):
    """One glTF node by name; absent fields stay as they are."""

    name: str
    translation: list[float] | None = Field(None, description="x y z, metres, relative to the parent node")
    rotation: list[float] | None = Field(None, description="quaternion x y z w, relative to the parent node")
    scale: list[float] | None = Field(None, description="scale per local axis (on the nodes *_scale)")
    weights: list[float] | None = Field(None, description="blendshape weights in the model's order (on the mesh node)")


class Started(Event):
    kind: Literal["started"] = "started"
    stance: Stance
    stance_reason: str
    preset: str
    model_sha256: str
    drawing: str | None
    iterations_limit: int
    notes: list[str] = Field(default=[], description="what reading and cleaning the scan found, one sentence each")
    landmarks_not_followed: list[DoubtedPick] = Field(
        default=[], description="picks that are doubted before the first step; `done` names all of them"
    )


class IterationNumbers(EventPart):
    """An iterated event without its nodes and modes."""

    iteration: int = Field(description="0 is the start, before the first step")
    stage: str
    energy: float = Field(description="comparable within one iteration only: matches and sigmas change")
    mean_distance_mm: float = Field(description="mean distance of matched model vertices to the scan")
    landmark_distance_mm: float | None = Field(description="mean over the picked landmarks")
    coverage: float = Field(description="share of the model's vertices with an accepted match")
    elapsed_s: float


class Iterated(IterationNumbers, Event):
    """One iteration."""

    kind: Literal["iterated"] = "iterated"
    nodes: list[NodePose]
    modes: list[float] = Field(default=[], description="weights of smooth modes, in the last stage; no node has them")


class Done(Event):
    kind: Literal["done"] = "done"
    result: ResultFile = Field(
        description="result.json; `verdict` says whether to trust it, `landmarks_not_followed` and `landmarks_unusual` "
        "name every pick that is asked about"
    )


class Failed(Event):
    kind: Literal["failed"] = "failed"
    reason: str


class Cancelled(Event):
    kind: Literal["cancelled"] = "cancelled"
    reason: str = "The fit was cancelled."


FitEvent = Annotated[Started | Iterated | Done | Failed | Cancelled, Field(discriminator="kind")]
LAST_KINDS = frozenset({"done", "failed", "cancelled"})


def event_json(event: Event) -> dict[str, Any]:
    """The event as it is stored and sent; a node names only what changes."""
    body = event.model_dump(mode="json")
    if "nodes" in body:
        body["nodes"] = [{key: value for key, value in node.items() if value is not None} for node in body["nodes"]]
    return body
