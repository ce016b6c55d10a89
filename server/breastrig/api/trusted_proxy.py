"""The reverse proxy that is believed when it says for whom it asks: `--trusted-proxy ADDRESS[,HOPS]`.

X-Forwarded-For, -Proto and -Host are taken over only from that address, and only as many of them, counted from the
end, as there are proxies in a row (HOPS): what stands before may have been written by anybody.  From everyone else
they are dropped.  Taking over is Werkzeug's ProxyFix.
"""

import ipaddress
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from werkzeug.middleware.proxy_fix import ProxyFix

FORWARDED = "breastrig.forwarded"  # in the WSGI environ: the trusted proxy asks; whether it said for whom
MOST_HOPS = 10
DROPPED = ("HTTP_FORWARDED", "HTTP_X_REAL_IP")  # say the same in other ways, and nothing here reads them


@dataclass(frozen=True)
class TrustedProxy:
    network: ipaddress.IPv4Network | ipaddress.IPv6Network
    hops: int = 1

    def __str__(self) -> str:
        alone = self.network.prefixlen == self.network.max_prefixlen
        place = self.network.network_address if alone else self.network
        return str(place) if self.hops == 1 else f"{place},{self.hops}"

    def is_at(self, address: str) -> bool:
        """Whether a connection from that address is the proxy's."""
        parsed = address_of(address)
        return parsed is not None and parsed in self.network


def read_trusted_proxy(text: str) -> TrustedProxy:
    """ADDRESS[,HOPS]; the address may be a network such as 10.0.0.0/24.  Raises ValueError with what is wrong."""
    place, _, hops = (part.strip() for part in text.partition(","))
    try:
        network = ipaddress.ip_network(place)
    except ValueError:
        raise ValueError("is not the address of a proxy; use an address such as 127.0.0.1, or 127.0.0.1,2") from None
    if hops and not (hops.isascii() and hops.isdigit() and 1 <= int(hops) <= MOST_HOPS):
        raise ValueError(f"has no number of proxies behind its comma; use 1 to {MOST_HOPS}")
    if network.prefixlen == 0:
        raise ValueError("would believe everybody; name the address of the proxy")
    return TrustedProxy(network, int(hops or 1))


def address_of(text: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address | None:
    """An IPv4 address that came through an IPv6 socket as what it is; None for what is no address."""
    try:
        parsed = ipaddress.ip_address(text)
    except ValueError:
        return None
    return getattr(parsed, "ipv4_mapped", None) or parsed


def client_of(address: str | None) -> str:
    """The key of one client: an address, or the 64-bit network of an IPv6 one, for a house has that many."""
    parsed = address_of(address or "")
    if parsed is None:
        return "unknown"
    if parsed.version == 6 and not parsed.is_loopback:
        return str(ipaddress.ip_network((parsed, 64), strict=False))
    return str(parsed)


class BehindProxy:
    """WSGI middleware that takes over what the trusted proxy forwards, once, and drops the same from all others."""

    def __init__(self, app: Callable[..., Iterable[bytes]], proxy: TrustedProxy | None) -> None:
        self._app = app
        self._proxy = proxy
        hops = 0 if proxy is None else proxy.hops
        self._fix = ProxyFix(lambda _environ, _start: [], x_for=hops, x_proto=hops, x_host=hops)

    def __call__(self, environ: dict[str, Any], start_response: Any) -> Iterable[bytes]:
        asks = environ.get("REMOTE_ADDR", "")
        if self._proxy is not None and FORWARDED not in environ and self._proxy.is_at(asks):
            environ[FORWARDED] = "HTTP_X_FORWARDED_FOR" in environ
            self._fix(environ, start_response)  # which the app within does not call
        environ["REMOTE_ADDR"] = str(address_of(environ.get("REMOTE_ADDR", "")) or environ.get("REMOTE_ADDR", ""))
        for name in [name for name in environ if name.startswith("HTTP_X_FORWARDED_") or name in DROPPED]:
            del environ[name]
        return self._app(environ, start_response)
