"""The settings of a service. Every caller needs a token; one is made at each start where none is given."""

import secrets
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from breastrig.api.people.people import People
from breastrig.api.trusted_proxy import TrustedProxy, address_of
from breastrig.archive.nodes import Node
from breastrig.core.errors import BadSettings
from breastrig.execution.limits import UploadLimits
from breastrig.service.sweep import KEEP_DAYS

TOKEN_VARIABLE = "BREASTRIG_TOKEN"
STREAMS = 64  # fifty viewers and some scripts
TOKEN_LENGTH = 16  # characters, at least; shorter ones can be guessed


@dataclass(frozen=True)
class Config:
    host: str = "127.0.0.1"
    token: str | None = None  # that every call below /api must bring, as bearer or in a session; None for none
    model: Path | None = None  # the rig's .glb; None for the packaged one
    web: Path | None = None  # folder of the built page; None for the packaged one
    examples: Path | None = None  # folder of the example patient; None for the packaged one
    keep_days: float | None = KEEP_DAYS  # scans are deleted so long after their upload; None keeps them
    uploads: UploadLimits = field(default_factory=UploadLimits)
    json_bytes: int = 20_000_000  # largest JSON body: the longest plan, with every digit and long notes, has 12 million
    heartbeat_s: float = 15.0  # proxies close a silent stream after 30 to 60 s
    proposal_wait_s: float = 8.0  # proposals take about 0.7 s; browsers and proxies wait for 30 s and more
    log_requests: bool = False
    streams: int = STREAMS  # open event streams
    trusted_proxy: TrustedProxy | None = None  # whose X-Forwarded-* are believed
    people: People | None = None  # who may sign in; None: whoever has the token
    public_hosts: tuple[str, ...] = ()  # names that outsiders call this server by; none: any, when there is a token

    archives: Mapping[str, Node] = field(default_factory=dict)  # the only places that results are sent to, by name

    @property
    def allowed_hosts(self) -> frozenset[str] | None:
        """Names that a request may call this server by; None for any, when the token protects it."""
        own = frozenset({"localhost", "127.0.0.1", "::1", self.host.lower()})
        if self.public_hosts:
            return own | frozenset(self.public_hosts)
        return None if is_exposed(self.host, self.trusted_proxy) else own


def is_loopback(host: str) -> bool:
    """Whether only programs on this machine can reach that address."""
    parsed = address_of(host)
    return host.lower() == "localhost" or (parsed is not None and parsed.is_loopback)


def is_exposed(host: str, proxy: TrustedProxy | None) -> bool:
    """Whether others than programs on this machine may ask; a proxy brings them even to a loopback address."""
    return proxy is not None or not is_loopback(host)


def checked_token(
    host: str, token: str | None, proxy: TrustedProxy | None = None, *, no_token: bool = False, users: bool = False
) -> str | None:
    """The token that callers must bring: the given one, or for callers on this machine a new one; None for `no_token`,
    and for `users`, who sign in.

    Raises BadSettings when it is too short, contradicts `no_token`, or others than this machine can call and none is
    given.
    """
    if token is not None and len(token) < TOKEN_LENGTH:
        raise BadSettings(f"{TOKEN_VARIABLE} is too short; give it at least {TOKEN_LENGTH} random characters.")
    if token is not None and no_token:
        raise BadSettings(f"A token is given and --no-token says that there is none; leave out {TOKEN_VARIABLE} or it.")
    if users and no_token:
        raise BadSettings(
            "--users says who may sign in and --no-token that everybody may do everything; leave out one."
        )
    if users:
        return token
    if token is None and is_exposed(host, proxy):
        opening = f"Listening on {host}" if proxy is None else "Being asked through a proxy"
        other = ", or listen on 127.0.0.1" if proxy is None else ""
        raise BadSettings(
            f"{opening} would show patients' scans to the network; set {TOKEN_VARIABLE} to a secret of at "
            f"least {TOKEN_LENGTH} characters (or write it into a file for --token-file){other}."
        )
    return token if token is not None or no_token else secrets.token_urlsafe(24)
