"""The audit log over the wire."""

from typing import Any

from pydantic import Field

from breastrig.api.wire.common import Paged, PageQuery, Wire

ID = r"^([A-Za-z0-9_-]{22})?$"
TIME = r"^[0-9TZ:.-]{0,30}$"
ANCHOR = r"^([0-9]{1,12}:[0-9a-f]{64})?$"


class AuditQuery(PageQuery):
    id: str = Field("", pattern=ID, description="only lines that name this patient, scan, fit or link")
    since: str = Field("", pattern=TIME, description="not older: ISO 8601, UTC, or the beginning of one")


class AuditLine(Wire):
    n: int
    at: str = Field(description="ISO 8601, UTC")
    who: str
    name: str | None = Field(None, description="of a person who had signed in")
    what: str
    how: str = Field("", description="the call or command")
    ids: dict[str, str] = Field({}, description="by kind: patient, scan, fit, link")
    line: int | None = Field(None, description="the earlier line that this one is about")
    status: int | None = None
    removes: dict[str, Any] | None = None
    left: int | None = None
    sha256: str = Field(description="of the line's bytes")


class AuditPage(Paged):
    lines: list[AuditLine] = Field(description="the newest first")


class AnchorQuery(Wire):
    anchor: str = Field("", pattern=ANCHOR, description="NUMBER:SHA256 of a line, as noted earlier")


class AuditCheck(Wire):
    lines: int
    end: str = Field(description="NUMBER:SHA256 of the last line, to be noted elsewhere")
    fault: str = Field(description="one sentence on the first line that is not as it was written; empty: none")
