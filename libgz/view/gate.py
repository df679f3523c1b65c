"""Gate: what the viewer's port answers, and to whom. Only pages whose address has the token can control."""

from __future__ import annotations

import base64
import hashlib
import ipaddress
import re
import secrets
from pathlib import Path
from urllib.parse import parse_qs, urlencode, urlsplit

from aiohttp import web

from libgz.view.assets import Asset, Assets
from libgz.view.portraits import Portraits

__all__ = ["Gate", "policy"]

CLIENT = Path(__file__).resolve().with_name("client")
KINDS = {
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".svg": "image/svg+xml",
}
SAFE_HEADERS = {"Server": "libgz", "Referrer-Policy": "no-referrer", "X-Content-Type-Options": "nosniff"}
HOST = re.compile(r"(?:[\w.-]+|\[[\da-fA-F:.]+\])(?::\d+)?", re.ASCII)
FOREVER = "public, max-age=31536000, immutable"
WORTH_PACKING = 1024  # [byte]
PORTRAITS = "/portraits/"  # before the name of a model
# Nothing is loaded from anywhere but this port, whatever a world's file says, and no text of it is ever run.
POLICY = (
    "default-src 'none'; script-src {scripts}; style-src {styles}; img-src 'self' data: blob:; "
    "connect-src {sources} data: blob:; base-uri 'none'; form-action 'none'"
)


def policy(scripts: str, styles: str, sources: str) -> str:
    """A Content-Security-Policy, by where its scripts, styles and connections may come from."""
    return POLICY.format(scripts=scripts, styles=styles, sources=sources)


def _place(address: str) -> str:
    """Host and port of an address; empty if it is none."""
    try:
        return urlsplit(address).netloc
    except ValueError:
        return ""


def script_source(text: str) -> str:
    """The source that allows a script within a page."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


class Gate:
    """Answers requests for the page, its modules and its assets.

    Args:
        host: address that is bound; of a loopback address, requests for other hosts' names are refused.
        assets: of the scene.
        portraits: of the catalogue, for pages that may control.
        token: of the address that may control; None for a new one.

    Attributes:
        token: of the address that may control.
    """

    def __init__(self, host: str, assets: Assets, portraits: Portraits, token: str | None = None) -> None:
        self.host, self.token, self._assets = host, token or secrets.token_urlsafe(18), assets
        self._portraits = portraits
        self._once: set[str] = set()
        known = (path for path in sorted(CLIENT.rglob("*")) if path.suffix in KINDS and path.is_file())
        files = {path.relative_to(CLIENT).as_posix(): path for path in known}
        digest = hashlib.sha256()
        for name, path in files.items():
            digest.update(name.encode() + path.read_bytes())
        self._base = f"/client/{digest.hexdigest()[:16]}/"
        page = (CLIENT / "index.html").read_text().replace('"client/', f'"{self._base}')
        found = re.search(r'<script type="importmap">(.*?)</script>', page, re.DOTALL)
        self._import_map = script_source(found[1] if found else "")
        self._page = Asset(page.encode(), KINDS[".html"])
        self._files = {
            self._base + name: Asset(path.read_bytes(), KINDS[path.suffix])
            for name, path in files.items()
            if name != "index.html"
        }

    def refusal(self, request: web.BaseRequest) -> web.Response | None:
        """Why a request is refused; None if it is not. Sockets of pages of other addresses are."""
        host = request.headers.get("Host", "")
        if not self._is_ours(host):
            return _response(403, "this host is not served here")
        if request.headers.get("Upgrade", "").lower() == "websocket":
            origin = request.headers.get("Origin")
            if origin is not None and _place(origin) != host:
                return _response(403, "pages of other addresses may not connect")
        return None

    def word_for_once(self) -> str:
        """A new word that is taken as the token once: every user sees the command of a browser."""
        word = secrets.token_urlsafe(18)
        self._once.add(word)
        return word

    def _is_first(self, word: str) -> bool:
        try:
            self._once.remove(word)
        except KeyError:
            return False
        return True

    def may_control(self, request: web.BaseRequest) -> bool:
        """Whether the address of a request has the token."""
        words = request.path.split("/")
        return len(words) > 2 and self._right(words[1])

    def local_path(self, request: web.BaseRequest) -> str:
        """The path of a request without the token, such as ``/socket``."""
        return request.path[len(self.token) + 1 :] if self.may_control(request) else request.path

    def _right(self, token: str) -> bool:
        return secrets.compare_digest(token.encode(), self.token.encode())

    def _is_ours(self, host: str) -> bool:
        """Whether a request names this machine: a name that others made point here is not served."""
        if not HOST.fullmatch(host):  # it stands in the policy
            return False
        try:
            name = urlsplit(f"//{host}").hostname or ""
        except ValueError:
            return False
        if name in ("localhost", self.host):
            return True
        try:
            ipaddress.ip_address(name)
            return True
        except ValueError:
            return not _is_loopback(self.host)

    def answer(self, request: web.BaseRequest) -> web.Response:
        """The response to a request that is not refused and opens no socket. It may take as long as reading a mesh."""
        if request.method not in ("GET", "HEAD"):
            return _response(405, "only GET is answered here")
        options = parse_qs(request.query_string)
        given = options.pop("token", [""])[0]
        if request.path == "/" and given:
            where = f"/{self.token}/" if self._right(given) or self._is_first(given) else "/"
            rest = urlencode(options, doseq=True)
            return _response(302, "", {"Location": f"{where}?{rest}" if rest else where})
        path = self.local_path(request)
        if path == "/":
            host = request.headers.get("Host", "")
            sources = f"'self' ws://{host} wss://{host}"
            headers = {"Content-Security-Policy": policy(f"'self' {self._import_map}", "'self'", sources)}
            return self._send(request, self._page, {"Cache-Control": "no-store", **headers})
        if path in self._files:
            return self._send(request, self._files[path], {"Cache-Control": FOREVER})
        if path.startswith("/assets/"):
            asset = self._assets.get(path[1:])
            if asset is not None:
                return self._send(request, asset, {"Cache-Control": FOREVER})
        if path.startswith(PORTRAITS) and self.may_control(request):
            portrait = self._portraits.get(path.removeprefix(PORTRAITS))
            if portrait is None:
                return _response(204, "")  # no error: some models have nothing to see
            return self._send(request, portrait, {"Cache-Control": "private, max-age=600"})
        return _response(404, "there is nothing here")

    def is_slow(self, request: web.BaseRequest) -> bool:
        """Whether an answer may take so long that no other one should wait for it."""
        return self.local_path(request).startswith(PORTRAITS)

    def _send(self, request: web.BaseRequest, asset: Asset, headers: dict[str, str]) -> web.Response:
        body, headers = asset.body, {**SAFE_HEADERS, **headers, "Content-Type": asset.kind}
        pays = len(body) > WORTH_PACKING and not asset.kind.startswith(("image/jpeg", "image/png"))
        if pays and "gzip" in request.headers.get("Accept-Encoding", ""):
            headers["Content-Encoding"] = "gzip"
            body = asset.packed
        return web.Response(body=body, headers=headers)


def _is_loopback(host: str) -> bool:
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def _response(status: int, text: str, more: dict[str, str] | None = None) -> web.Response:
    headers = {**SAFE_HEADERS, "Cache-Control": "no-store", **(more or {})}
    return web.Response(status=status, text=text, headers=headers)
