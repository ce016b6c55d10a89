"""The JSON shapes of share links."""

from typing import Annotated, Literal

from pydantic import Field

from breastrig.api.share_limits import PASSCODE_LENGTH
from breastrig.api.wire.common import Links, Name, Paged, Wire

ShareScan = Literal["none", "plain", "full"]


class ShareRequest(Wire):
    expires_in_days: int = Field(7, ge=1, le=90)
    passcode: str | None = Field(
        None, min_length=PASSCODE_LENGTH, max_length=100, description="asked for at the opening"
    )
    scan: ShareScan = Field(
        "none",
        description="whether the scan is shown: not at all (the model alone, without the layer that follows the skin), "
        "its shape without colours, or with its colours",
    )
    notes: bool = Field(False, description="whether the plan's notes are shown")


class ShareLinks(Links):
    self: Annotated[str, ""]
    unlock: Annotated[str, "/unlock"]
    refresh: Annotated[str, "/refresh"]


class Share(Wire):
    id: str = Field(description="is in the addresses of the owner and of visitors; it opens nothing")
    created_at: str = Field(description="ISO 8601, UTC")
    expires_at: str
    revoked_at: str | None
    is_open: bool = Field(description="neither expired nor revoked nor locked")
    is_locked: bool = Field(description="so many wrong passcodes were given that it takes none until it is unlocked")
    scan: ShareScan
    notes: bool
    shown_at: str | None = Field(description="what stood then is what the link shows; null when it is of no version")
    has_passcode: bool
    openings: int
    last_opened_at: str | None
    wrong_passcodes: int = Field(description="given in all, whoever gave them")
    last_wrong_passcode_at: str | None
    links: ShareLinks


class ShareMade(Share):
    url: str = Field(description="address of the page with the secret behind #; it is shown only once")


class ShareWithOpenings(Share):
    opened_at: list[str] = Field(description="the last openings, the newest first; nothing about who")


class SharePage(Paged):
    shares: list[Share] = Field(description="the newest first")


class ShareOpening(Wire):
    token: Name = Field(description="what stands behind # in the link")
    passcode: str | None = Field(None, max_length=100)


class SharedLinks(Links):
    self: Annotated[str, ""]
    result: Annotated[str, "/result.json"]
    fitted_glb: Annotated[str, "/fitted.glb"]
    fitted_ply: Annotated[str, "/fitted.ply"]
    drawing: Annotated[str, "/drawing.json"]
    distances: str | None = Field(description="null when the link does not show the scan, which they would tell")
    plan: Annotated[str, "/plan.json"]
    report: str | None = Field(
        description="null when the link does not show the scan, which it pictures, or none can be made"
    )
    mesh: str | None = Field(description="null when the link does not show the scan")
    close: Annotated[str, "/close"]


class SharedResult(Wire):
    id: str = Field(description="of the share; it opens nothing")
    expires_at: str
    shown_at: str | None = Field(description="what stood then is shown")
    links: SharedLinks
