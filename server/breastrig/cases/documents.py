"""The schemas of a case's documents; each names its own form, and unknown fields are ignored."""

import hashlib
from collections.abc import Mapping
from typing import Any, Literal, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from breastrig.core.documents import json_bytes
from breastrig.core.errors import BadInput
from breastrig.drawings.plan_schema import ITEMS, Plan, PlanItem

SCALE = "size in which places are: times that of the scan's file"
NOTHING = "0"  # the ETag of a document that nobody has written yet

Read = TypeVar("Read", bound=BaseModel)


class Document(BaseModel):
    model_config = ConfigDict(extra="ignore", frozen=True, populate_by_name=True, defer_build=True)


class CaseDocument(Document):
    """case.json: the patient under a code, never a name."""

    schema_: Literal["breastrig/case@1"] = Field(default="breastrig/case@1", alias="schema")
    code: str = Field(max_length=60)
    created_at: str = Field(description="ISO 8601, UTC")
    group: str | None = Field(default=None, description="of people (`serve --users`) that owns the patient")


class PlanDocument(Plan):
    """plan.json, and plans/NUMBER.json of earlier versions."""

    items: list[PlanItem] = Field(default=[], max_length=ITEMS)
    version: int = Field(default=0, description="grows by one with each change; 0 before the first")
    sizes: dict[str, float] = Field(
        default={}, description="by scan, as `scale` of its landmarks: the size in which places on it are, where not 1"
    )
    whole: bool = Field(
        default=False, description="somebody has written it as a whole: what it does not name is not wanted"
    )
    written_at: str = ""


class ScanDocument(Document):
    """scan.json: what was read of an upload; it never changes."""

    schema_: Literal["breastrig/scan@1"] = Field(default="breastrig/scan@1", alias="schema")
    created_at: str
    sha256: str = Field(description="of the file's bytes")
    facts: dict[str, Any] = Field(description="what reading found: unit, counts, bounds, frame, stance, notes")
    file: str = Field(
        default="scan.stored",
        pattern=r"^scan\.[a-z0-9]{1,8}$",
        description="of early versions the upload",
    )


class CutsDocument(Document):
    """cuts.json: what a person has cut away by hand (scan/hand_cuts.py)."""

    schema_: Literal["breastrig/cuts@1"] = Field(default="breastrig/cuts@1", alias="schema")
    scale: float = Field(default=1.0, gt=0.0, description=SCALE)
    cuts: list[dict[str, Any]] = []


class InkDocument(Document):
    """ink.json: lines that were found on the skin (breastrig/drawing@1), and which of them are none of the plan."""

    model_config = ConfigDict(extra="allow")
    schema_: Literal["breastrig/drawing@1"] = Field(default="breastrig/drawing@1", alias="schema")
    scale: float = Field(default=1.0, gt=0.0, description=SCALE)
    unit: Literal["mm"] = "mm"
    shapes: list[dict[str, Any]] = []
    dropped: list[str] = []


class AnswersDocument(Document):
    """answers.json: facts about a scan that a person has said; what nobody has said is null."""

    schema_: Literal["breastrig/answers@1"] = Field(default="breastrig/answers@1", alias="schema")
    stance: Literal["standing", "supine", "prone"] | None = None
    side: Literal["L", "R"] | None = Field(default=None, description="the patient's side that the scan is about")
    visit: str | None = Field(default=None, max_length=60, description="such as: before, after six months")
    visit_date: str | None = Field(default=None, description="ISO 8601, the day on which the scan was taken")
    model: str | None = Field(default=None, max_length=100, description="name of the scan's model, said to be right")
    same_as: list[str] = Field(
        default=[], description="scans of the case that are of the same patient, though the bodies do not look like it"
    )


class ProposalsDocument(Document):
    """proposals.json: landmarks that a model has proposed; it may vanish."""

    schema_: Literal["breastrig/proposals@1"] = Field(default="breastrig/proposals@1", alias="schema")
    key: str = Field(description="of the model, and of the cuts")
    landmarks: dict[str, Any]


class FitDocument(Document):
    """fit.json: a fit as it was asked for; it never changes."""

    schema_: Literal["breastrig/fit@1"] = Field(default="breastrig/fit@1", alias="schema")
    asked_at: str
    stance: str = "auto"
    preset: str = "default"
    drawing: str | None = None
    landmarks_mm: dict[str, list[float]] = {}
    certain: list[str] = []
    confidence: dict[str, float] = {}
    marks_mm: dict[str, list[float]] = {}
    cuts: list[dict[str, Any]] = []
    scale: float = Field(default=1.0, gt=0.0, description=SCALE)
    refine: bool = True
    start_from: str | None = Field(default=None, description="an earlier fit of the same scan")
    predicted_from: str | None = Field(default=None, description="of a prediction: the fit that it comes from")
    key_sha256: str | None = Field(default=None, description="of the Idempotency-Key")
    request_sha256: str | None = Field(default=None, description="of the request that came with it")


class LinkDocument(Document):
    """link.json: a share link without its secrets, which only the index has."""

    schema_: Literal["breastrig/link@1"] = Field(default="breastrig/link@1", alias="schema")
    created_at: str
    expires_at: str
    revoked_at: str | None = None
    scan: Literal["none", "plain", "full"] = "plain"
    notes: bool = False
    shown: int = Field(default=0, description="N of shown-N, the folder of what it shows; 0: nothing any more")
    shown_at: str | None = None


class ExpiresDocument(Document):
    """expires.json: the scan's deletion by age has been announced."""

    schema_: Literal["breastrig/expires@1"] = Field(default="breastrig/expires@1", alias="schema")
    announced_at: str


def content_of(document: BaseModel | Mapping[str, Any]) -> bytes:
    """The document as a file, indented for people."""
    if isinstance(document, BaseModel):
        return json_bytes(document.model_dump(mode="json", by_alias=True))
    return json_bytes(document)


def read_document(kind: type[Read], content: bytes, name: str) -> Read:
    """The document in a file's bytes; `name` is the file's.  BadInput for what is none of that kind."""
    try:
        return kind.model_validate_json(content)
    except (ValidationError, RecursionError) as error:
        where = ""
        if isinstance(error, ValidationError):
            where = ".".join(map(str, error.errors(include_url=False, include_input=False)[0]["loc"]))
        raise BadInput(f"{name} of this case is damaged ({where or 'the whole'}); put a copy back.") from error


def etag_of(content: bytes) -> str:
    """The SHA-256 of a file's bytes; a number would be repeated by hand edits and restored copies."""
    return hashlib.sha256(content).hexdigest()
