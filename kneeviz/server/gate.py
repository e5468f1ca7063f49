"""Who may come in: the names that the server goes by, the pages that may speak to it, the token.

A browser lets a page of any site open a WebSocket to this machine, and a name that its owner points
at 127.0.0.1 (DNS rebinding) makes such a page look like our own. So a request must name a host that
we go by, a page's request must come from our own page, and where others can reach the server, the
visitor must have been given the whole address.
"""

import hmac
import ipaddress
import re
import secrets
import socket
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Protocol
from urllib.parse import parse_qs, urlsplit

from kneecore import ParameterError

_TOKEN = re.compile(r"[A-Za-z0-9_-]{16,128}")
_NAME = re.compile(r"[a-z0-9_-]+(\.[a-z0-9_-]+)*")
_PORTS = {"http": 80, "https": 443}
_EVERYWHERE = ("", "0.0.0.0", "::")


class Headers(Protocol):
    """What the gate needs of a request's headers; those of the package websockets have it."""

    def get_all(self, key: str) -> list[str]:
        """Return all values of a header."""


def _address(name: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address | None:
    try:
        return ipaddress.ip_address(name)
    except ValueError:
        return None


def _is_local(name: str) -> bool:
    """Tell whether a name means this machine wherever it is said; asks nobody."""
    address = _address(name)
    return name == "localhost" if address is None else address.is_loopback


def is_loopback(host: str) -> bool:
    """Tell whether a server that listens on `host` can be reached from this machine only."""
    if host in _EVERYWHERE or _is_local(host):
        return host not in _EVERYWHERE
    try:
        found = socket.getaddrinfo(host, None, type=socket.SOCK_STREAM)
    except OSError:
        return False
    addresses = [_address(str(entry[4][0])) for entry in found]
    return all(address is not None and address.is_loopback for address in addresses)


def bracketed(host: str) -> str:
    """Return `host` as it is written in a URL: an IPv6 address in brackets."""
    return f"[{host.replace('%', '%25')}]" if ":" in host else host


def new_token() -> str:
    """Return a token that nobody can guess (128 bits)."""
    return secrets.token_urlsafe(16)


@dataclass(frozen=True)
class Place:
    """A host and a port as a header or an address names them."""

    host: str
    """A name in small letters or an address without brackets."""
    port: int | None
    """None where the scheme's own port is meant."""


def _place(text: str) -> Place | None:
    """Read ``host[:port]``; None if it is nothing of the kind."""
    if re.search(r"[\s/?#@\\,]", text):
        return None
    try:
        parts = urlsplit(f"//{text}")
        host, port = parts.hostname, parts.port
    except ValueError:
        return None
    if not host:
        return None
    return Place(host.lower().rstrip("."), port)


@dataclass(frozen=True, kw_only=True)
class Gate:
    """The rules by which a request is let in.

    Raises
    ------
    ParameterError
        If the token can be guessed or does not go into an address, or a name is no host's name.
    """

    host: str
    """Where the server listens."""
    allowed: tuple[str, ...] = ()
    """Further names under which it is reached, through a proxy or a tunnel."""
    token: str | None = None
    """What an address must carry, or None."""
    lead: str | None = None
    """What a class's teacher carries, who alone may change what is shown; None without a class."""
    _names: frozenset[str] = field(init=False, repr=False)
    _local: bool = field(init=False, repr=False)
    """Whether the server itself can be reached from this machine only."""

    def __post_init__(self) -> None:
        for token in (self.token, self.lead):
            if token is not None and not _TOKEN.fullmatch(token):
                raise ParameterError(
                    "the token must be 16 to 128 letters, digits, - or _ (it is not shown here)"
                )
        allowed = tuple(name.lower().rstrip(".") for name in self.allowed)
        for name in allowed:
            if not _NAME.fullmatch(name) and _address(name) is None:
                raise ParameterError(
                    f"`allow_host` is {name!r}; a host's name without scheme and port is needed"
                )
        own = {"localhost", self.host.lower(), *allowed}
        local = is_loopback(self.host)
        if not local:
            own.add(socket.gethostname().lower())
        object.__setattr__(self, "allowed", allowed)
        object.__setattr__(self, "_names", frozenset(own - {""}))
        object.__setattr__(self, "_local", local)

    @property
    def is_private(self) -> bool:
        """Whether only this machine is meant to reach the server."""
        return self._local and all(_is_local(name) for name in self.allowed)

    @classmethod
    def of(
        cls,
        host: str,
        *,
        token: str | bool | None,
        allowed: Iterable[str] = (),
        for_class: bool = False,
    ) -> "Gate":
        """Return the rules for a host: with a token by default where others can reach it.

        Parameters
        ----------
        host : str
            Where the server listens.
        token : str, bool or None
            A token of one's own, True for a new one, False for none, None for the default.
        allowed : iterable of str
            Further names under which the server is reached.
        for_class : bool
            Whether there is a teacher, who gets a token of his own.
        """
        names = tuple(allowed)
        if token is None:
            token = not cls(host=host, allowed=names).is_private
        value = new_token() if token is True else token
        return cls(
            host=host,
            allowed=names,
            token=None if value is False else value,
            lead=new_token() if for_class else None,
        )

    def refusal(self, target: str, headers: Headers) -> str | None:
        """Return why a request is refused, in a line for whoever sent it, or None.

        Parameters
        ----------
        target : str
            The path that is asked for, with its query.
        headers : Headers
            The request's headers.
        """
        hosts = headers.get_all("Host")
        here = _place(hosts[0]) if len(hosts) == 1 else None
        if here is None or not self._knows(here.host):
            shown = here.host if here is not None and _NAME.fullmatch(here.host) else "that name"
            return f"This server does not go by {shown}; --allow-host would let it."
        if not all(self._is_own_page(origin, here) for origin in headers.get_all("Origin")):
            return "Pages of other sites may not speak to this server."
        if self.token is None or self.has_token(target, headers):
            return None
        return "This address needs a token: open the whole address that the server printed."

    def _knows(self, name: str) -> bool:
        if name in self._names:
            return True
        address = _address(name)
        # Nobody can point an address, unlike a name, at another machine.
        return address is not None and (address.is_loopback or not self._local)

    def _is_own_page(self, origin: str, here: Place) -> bool:
        scheme, separator, rest = origin.partition("://")
        there = _place(rest)
        if not separator or scheme not in _PORTS or there is None:
            return False  # "null": a page from a file or in a sandbox
        if there.host in self.allowed:
            return True
        usual = _PORTS[scheme]
        return there.host == here.host and (there.port or usual) == (here.port or usual)

    def has_token(self, target: str, headers: Headers) -> bool:
        """Tell whether a request carries the token or the teacher's, in its address or a cookie."""
        name = self._cookie_name(headers)
        return self._carries(self.token, name, target, headers) or self.leads(target, headers)

    def leads(self, target: str, headers: Headers) -> bool:
        """Tell whether a request carries the token of a class's teacher."""
        return self._carries(self.lead, self._lead_cookie_name(headers), target, headers)

    def _carries(self, token: str | None, cookie: str, target: str, headers: Headers) -> bool:
        if token is None:
            return False
        given = [*self._in_address(target), *self._in_cookies(cookie, headers)]
        return any(
            hmac.compare_digest(value.encode(errors="surrogateescape"), token.encode())
            for value in given
        )

    def _in_address(self, target: str) -> list[str]:
        try:
            return parse_qs(target.partition("?")[2], max_num_fields=20).get("token", [])
        except ValueError:
            return []

    def _in_cookies(self, name: str, headers: Headers) -> list[str]:
        pairs = (
            pair.strip().partition("=")
            for line in headers.get_all("Cookie")
            for pair in line.split(";")
        )
        return [value for key, _, value in pairs if key == name]

    def _cookie_name(self, headers: Headers) -> str:
        """Name the cookie after the port: a browser gives all ports of a host the same cookies."""
        here = _place(next(iter(headers.get_all("Host")), ""))
        return f"kneeviz-{0 if here is None else here.port or 0}"

    def _lead_cookie_name(self, headers: Headers) -> str:
        return f"{self._cookie_name(headers)}-lead"

    def answer_headers(self, target: str, headers: Headers) -> dict[str, str]:
        """Return what the answer with the page must carry.

        The cookie lets the page come back, and its WebSocket in, without the token in the address.
        """
        answer = {
            "Referrer-Policy": "no-referrer",
            "X-Content-Type-Options": "nosniff",
            "Content-Security-Policy": "frame-ancestors 'self'",
            "Cache-Control": "private",
        }
        cookie = None
        if self.leads(target, headers):
            cookie = f"{self._lead_cookie_name(headers)}={self.lead}"
        elif self.token is not None and self.has_token(target, headers):
            cookie = f"{self._cookie_name(headers)}={self.token}"
        if cookie is not None:
            answer["Set-Cookie"] = f"{cookie}; Path=/; HttpOnly; SameSite=Strict"
        return answer

    def url(self, port: int) -> str:
        """Return the address to open in a browser on this machine: the teacher's in a class."""
        here = {"": "127.0.0.1", "0.0.0.0": "127.0.0.1", "::": "::1"}.get(self.host, self.host)
        return self._address(here, port, self.token if self.lead is None else self.lead)

    def class_url(self, port: int) -> str:
        """Return the address that a class is given: who opens it only watches."""
        everywhere = self.host in _EVERYWHERE
        there = next(iter(self.allowed), socket.gethostname().lower() if everywhere else self.host)
        return self._address(there, port, self.token)

    def _address(self, host: str, port: int, token: str | None) -> str:
        address = f"http://{bracketed(host)}:{port}"
        return address if token is None else f"{address}/?token={token}"

    def warning(self, port: int) -> str | None:
        """Return what may go wrong where others can reach the server, in a line, or None."""
        if self.is_private:
            return None
        where = f"{bracketed(self.host) or 'all addresses'}:{port}"
        who = "whoever can reach" if self.token is None else "whoever has the token and can reach"
        does = "change what is shown, upload files and keep this machine busy"
        if self.lead is not None:
            does = f"watch, and whom the teacher lets drive can {does}"
        return (
            f"{who} {where} can {does}, "
            "and the connection is not encrypted; use it among people you trust, "
            "or keep to 127.0.0.1 and a tunnel"
        )
