"""Gate: what the page's port answers. Only pages whose address has the token can control; the others only watch."""

from __future__ import annotations

import asyncio
import contextlib
import contextvars
import functools
import gzip
import http
import ipaddress
import json
import logging
import secrets
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, urlsplit

import msgspec.msgpack
import viser
import websockets.asyncio.server
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

__all__ = ["LEAN_SCRIPT", "POLICY", "Gate", "may_control"]

CONTROL_SCRIPT, LEAN_SCRIPT = (Path(__file__).with_name(name) for name in ("page.js", "lean.js"))
WATCHING = {"ViewerCameraMessage"}  # all that a page without the token may send
NEVER = {"ShareUrlRequest", "ShareUrlDisconnect"}  # would make the page public through a server of others
# Nothing is loaded from anywhere but this port, whatever a world's file says.
POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval' blob: data:; worker-src blob: data:; "
    "style-src 'unsafe-inline'; img-src data: blob:; font-src data:; media-src 'none'; object-src 'none'; "
    "connect-src 'self' {socket} data: blob:; base-uri 'none'; form-action 'none'"
)
SAFE_HEADERS = {"Referrer-Policy": "no-referrer", "X-Content-Type-Options": "nosniff", "Cache-Control": "no-store"}
LARGEST_NOTE = 4096  # [byte]
LARGEST_MESSAGE = 1 << 20  # [byte] of a page
LARGEST_NUMBER = 1e9  # of a message: metres, pixels, times [s]

may_control: contextvars.ContextVar[bool] = contextvars.ContextVar("may_control", default=False)

# Browsers open connections in advance, and close them unused: that is no error.
QUIET = logging.getLogger("libgz.view.port")
QUIET.setLevel(logging.CRITICAL)

OnNote = Callable[[dict[str, Any], int], None]


class _Checked:
    """A connection whose messages are dropped if `allowed` does not let them through, or a number is out of range."""

    def __init__(self, connection: Any, allowed: Callable[[str], bool]) -> None:
        self._connection, self._allowed = connection, allowed

    def __getattr__(self, name: str) -> Any:
        return getattr(self._connection, name)

    async def recv(self) -> bytes:
        """The next message that may pass."""
        while True:
            raw = await self._connection.recv()
            try:
                message = msgspec.msgpack.decode(raw) if isinstance(raw, bytes) else None
            except (msgspec.DecodeError, RecursionError):
                continue
            if isinstance(message, dict) and self._allowed(str(message.get("type", ""))) and _is_sane(message):
                return bytes(raw)


def _is_sane(value: Any, depth: int = 8) -> bool:
    """Whether all numbers of a message are within +-`LARGEST_NUMBER`, and it is not nested deeper than pages send."""
    if isinstance(value, int | float):
        return abs(value) <= LARGEST_NUMBER
    if isinstance(value, dict | list):
        inside = value.values() if isinstance(value, dict) else value
        return depth > 0 and all(_is_sane(item, depth - 1) for item in inside)
    return True


class Gate:
    """Answers the page's port: the page itself, its connection, and the notes of the page's own script.

    Args:
        host: address that is bound; of a loopback address, requests for other hosts' names are refused.
        title: of the page.
        on_note: called with each note of a page that may control, and the number of its connection; in the server's
            thread. The note ``{"closed": true}`` ends a connection.
        token: of the address that may control; None for a new one.

    Attributes:
        token: of the address that may control.
    """

    def __init__(self, host: str, title: str, on_note: OnNote, token: str | None = None) -> None:
        self.host, self.token = host, token or secrets.token_urlsafe(18)
        self._on_note = on_note
        self._title = title
        self._pages: dict[bool, bytes] = {}
        self._notebooks: dict[int, Any] = {}
        self._last: dict[str, Any] = {}
        self._count = 0
        self._loop: asyncio.AbstractEventLoop | None = None
        self._lock = threading.Lock()

    @contextlib.contextmanager
    def guarding(self) -> Iterator[None]:
        """Put this gate before the server that viser starts meanwhile."""
        module, plain = websockets.asyncio.server, websockets.asyncio.server.serve

        def serve(handler: Any, host: Any, port: Any, **options: Any) -> Any:
            options["process_request"] = self._answer
            options["logger"] = QUIET
            options["max_size"] = LARGEST_MESSAGE
            return plain(functools.partial(self._connect, handler), host, port, **options)

        module.serve = serve  # type: ignore[assignment,misc]
        try:
            yield
        finally:
            module.serve = plain  # type: ignore[misc]

    # Requests --------------------------------------------------------------------------------------------------------

    def _answer(self, _connection: Any, request: Request) -> Response | None:
        """The response to a request; None lets a socket connect."""
        host = request.headers.get("Host", "")
        if not self._is_ours(host):
            return _response(http.HTTPStatus.FORBIDDEN, "this host is not served here")
        parts = urlsplit(request.path)
        if request.headers.get("Upgrade", "").lower() == "websocket":
            origin = request.headers.get("Origin")
            if origin is not None and urlsplit(origin).netloc != host:
                return _response(http.HTTPStatus.FORBIDDEN, "pages of other addresses may not connect")
            return None
        given = parse_qs(parts.query).get("token", [""])[0]
        if parts.path in ("", "/") and given:
            where = f"/{self.token}/" if self._right(given) else "/"
            return _response(http.HTTPStatus.FOUND, "", {"Location": where})
        words = [word for word in parts.path.split("/") if word]
        if not words or (len(words) == 1 and self._right(words[0])):
            return self._page(bool(words), request, host)
        return _response(http.HTTPStatus.NOT_FOUND, "there is nothing here")

    def _right(self, token: str) -> bool:
        return secrets.compare_digest(token.encode(), self.token.encode())

    def _is_ours(self, host: str) -> bool:
        """Whether a request names this machine: a name that others made point here is not served."""
        name = urlsplit(f"//{host}").hostname or ""
        if name in ("localhost", self.host):
            return True
        try:
            ipaddress.ip_address(name)
            return True
        except ValueError:
            return not _loopback(self.host)

    def _page(self, control: bool, request: Request, host: str) -> Response:
        if control not in self._pages:
            text = (Path(viser.__file__).parent / "client" / "build" / "index.html").read_text()
            text = text.replace("<title>Viser</title>", f"<title>{_text(self._title)}</title>", 1)
            own = f"window.libgzControl={json.dumps(control)};\n{CONTROL_SCRIPT.read_text()}\n{LEAN_SCRIPT.read_text()}"
            script = f"<script>{own}</script>"
            self._pages[control] = gzip.compress(text.replace("<head>", f"<head>{script}", 1).encode(), 1)
        body, headers = self._pages[control], dict(SAFE_HEADERS)
        headers["Content-Security-Policy"] = POLICY.format(socket=f"ws://{host} wss://{host}")
        if "gzip" in request.headers.get("Accept-Encoding", ""):
            headers["Content-Encoding"] = "gzip"
        else:
            body = gzip.decompress(body)
        headers["Content-Type"] = "text/html; charset=utf-8"
        headers["Content-Length"] = str(len(body))
        return Response(200, "OK", Headers(headers), body)

    # Sockets ---------------------------------------------------------------------------------------------------------

    async def _connect(self, handler: Any, connection: Any) -> None:
        words = [word for word in urlsplit(connection.request.path).path.split("/") if word]
        control = bool(words) and self._right(words[0])
        if words[1:] == ["notes"] and control:
            await self._take_notes(connection)
            return
        may_control.set(control)
        allowed: Callable[[str], bool] = (lambda kind: kind not in NEVER) if control else WATCHING.__contains__
        await handler(_Checked(connection, allowed))

    async def _take_notes(self, connection: Any) -> None:
        self._loop = asyncio.get_running_loop()
        with self._lock:
            self._count += 1
            number = self._count
            self._notebooks[number] = connection
        try:
            if self._last:
                await connection.send(json.dumps(self._last))
            async for raw in connection:
                with contextlib.suppress(ValueError):
                    note = json.loads(raw) if len(raw) <= LARGEST_NOTE else None
                    if isinstance(note, dict):
                        self._on_note(note, number)
        except ConnectionClosed:
            pass
        finally:
            with self._lock:
                self._notebooks.pop(number, None)
            self._on_note({"closed": True}, number)

    def notify(self, **facts: Any) -> None:
        """Send facts to the scripts of all pages that may control, and to those that come; only what is new."""
        if facts == self._last:
            return
        self._last = facts
        with self._lock:
            connections = list(self._notebooks.values())
        for connection in connections:
            if self._loop is not None:
                asyncio.run_coroutine_threadsafe(_send(connection, json.dumps(facts)), self._loop)


async def _send(connection: Any, text: str) -> None:
    with contextlib.suppress(ConnectionClosed):
        await connection.send(text)


def _loopback(host: str) -> bool:
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def _response(status: http.HTTPStatus, text: str, more: dict[str, str] | None = None) -> Response:
    body = text.encode()
    headers = {"Content-Type": "text/plain", "Content-Length": str(len(body)), **SAFE_HEADERS, **(more or {})}
    return Response(status.value, status.phrase, Headers(headers), body)


def _text(text: str) -> str:
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
