"""libgz lsp: a language server for worldfiles and SDF files, over standard input and output.

Texts are checked in a process of their own, so that none can disturb the server, and without their plugins.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import json
import logging
from pathlib import Path
from typing import TYPE_CHECKING, Any

from libgz._version import __version__
from libgz.base.errors import LibraryError
from libgz.base.extras import install
from libgz.base.python import run_module
from libgz.reference.language import Completion, completions, meaning

if TYPE_CHECKING:
    from lsprotocol import types
    from pygls.lsp.server import LanguageServer

__all__ = ["configure", "new_server", "run"]

log = logging.getLogger("libgz.lsp")

SOURCE = "libgz"
DELAY = 0.3  # [s] after the last change, until a text is checked
PATIENCE = 60.0  # [s] for a check
LONGEST = 16 << 20  # characters of a text that is checked
MOST_SHOWN = 500  # diagnostics of a file
UNTRUSTED = "files are untrusted"  # in what is reported of code that was not run
TRIGGERS = ("<", ":", " ", '"', "'", ">")


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument(
        "--trust", action="store_true", help="run the plugins of worldfiles, to check what they read of their elements"
    )


def run(options: argparse.Namespace) -> int:
    """Serve one editor until it ends.

    Raises:
        LibraryError: the extra is not installed.
    """
    new_server(trust=options.trust).start_io()
    return 0


class _Checks:
    """Checks texts a moment after they change, and publishes what is found; one check of a text at a time."""

    def __init__(self, server: LanguageServer, trust: bool) -> None:
        self._server, self._trust = server, trust
        self._tasks: dict[str, asyncio.Task[None]] = {}

    def begin(self, uri: str) -> None:
        """Check a text soon, and give up a check of it that runs."""
        self.end(uri)
        self._tasks[uri] = asyncio.ensure_future(self._check(uri))

    def end(self, uri: str) -> None:
        """Check a text no more."""
        task = self._tasks.pop(uri, None)
        if task is not None:
            task.cancel()

    async def _check(self, uri: str) -> None:
        from lsprotocol import types

        await asyncio.sleep(DELAY)
        document = self._server.workspace.get_text_document(uri)
        text, version = document.source, document.version
        if len(text) > LONGEST:
            return
        found = await self._diagnostics(Path(document.path), text)
        lines = text.splitlines()
        shown = [_shown(one, lines, document.path) for one in found[:MOST_SHOWN]]
        self._server.text_document_publish_diagnostics(types.PublishDiagnosticsParams(uri, shown, version))

    async def _diagnostics(self, path: Path, text: str) -> list[dict[str, Any]]:
        """What `libgz check` reports of a text."""
        words = ["--json", "--stdin", *([] if self._trust else ["--untrusted"]), "--", str(path.absolute())]
        pipe = asyncio.subprocess.PIPE
        process = await asyncio.create_subprocess_exec(
            *run_module("libgz", "check", *words),
            stdin=pipe,
            stdout=pipe,
            stderr=pipe,
            cwd=path.parent if path.parent.is_dir() else None,
        )
        try:
            answer, errors = await asyncio.wait_for(process.communicate(text.encode("utf-8", "replace")), PATIENCE)
        except TimeoutError:
            return [_whole_file(f"the check took longer than {PATIENCE:g} s and was ended")]
        finally:
            if process.returncode is None:
                with contextlib.suppress(ProcessLookupError):
                    process.kill()
        try:
            found: list[dict[str, Any]] = json.loads(answer)
        except ValueError:
            return [_whole_file(errors.decode(errors="replace").strip() or "the check failed")]
        return found


def _whole_file(message: str) -> dict[str, Any]:
    return {"file": "", "line": 0, "element": "", "message": message, "severity": "error"}


def _shown(one: dict[str, Any], lines: list[str], path: str) -> types.Diagnostic:
    """A diagnostic of `libgz check`, for an editor; one of another file is at the beginning, with its place."""
    from lsprotocol import types

    here = one["file"] in ("", path) or Path(one["file"]) == Path(path)
    number = max(int(one["line"]) - 1, 0) if here else 0
    line = lines[number] if number < len(lines) else ""
    place = "" if here else f"{one['file']}:{one['line']}: "
    element = f"<{one['element']}>: " if one["element"] else ""
    severity = types.DiagnosticSeverity.Error if one["severity"] == "error" else types.DiagnosticSeverity.Warning
    if UNTRUSTED in one["message"]:
        severity = types.DiagnosticSeverity.Information
    start = len(line) - len(line.lstrip())
    return types.Diagnostic(
        types.Range(types.Position(number, start), types.Position(number, max(len(line.rstrip()), start + 1))),
        f"{place}{element}{one['message']}",
        severity=severity,
        source=SOURCE,
    )


def new_server(*, trust: bool = False) -> LanguageServer:
    """A language server.

    Raises:
        LibraryError: the extra is not installed.
    """
    try:
        from lsprotocol import types
        from pygls.lsp.server import LanguageServer
    except ImportError as error:
        raise LibraryError(f"the language server needs the extra `lsp`: {install('lsp')} ({error})") from None
    server = LanguageServer("libgz", __version__, text_document_sync_kind=types.TextDocumentSyncKind.Full)
    checks = _Checks(server, trust)

    @server.feature(types.TEXT_DOCUMENT_DID_OPEN)
    async def opened(parameters: types.DidOpenTextDocumentParams) -> None:
        checks.begin(parameters.text_document.uri)

    @server.feature(types.TEXT_DOCUMENT_DID_CHANGE)
    async def changed(parameters: types.DidChangeTextDocumentParams) -> None:
        checks.begin(parameters.text_document.uri)

    @server.feature(types.TEXT_DOCUMENT_DID_SAVE)
    async def saved(parameters: types.DidSaveTextDocumentParams) -> None:
        checks.begin(parameters.text_document.uri)

    @server.feature(types.TEXT_DOCUMENT_DID_CLOSE)
    async def closed(parameters: types.DidCloseTextDocumentParams) -> None:
        uri = parameters.text_document.uri
        checks.end(uri)
        server.text_document_publish_diagnostics(types.PublishDiagnosticsParams(uri, []))

    @server.feature(types.TEXT_DOCUMENT_COMPLETION, types.CompletionOptions(trigger_characters=TRIGGERS))
    async def complete(parameters: types.CompletionParams) -> types.CompletionList:
        document = server.workspace.get_text_document(parameters.text_document.uri)
        position = parameters.position
        offset = document.offset_at_position(position)
        begun = _begun(document.source, offset)
        start = types.Position(position.line, max(position.character - begun, 0))
        items = [_item(one, types.Range(start, position)) for one in completions(document.source, offset)]
        return types.CompletionList(is_incomplete=False, items=items)

    @server.feature(types.TEXT_DOCUMENT_HOVER)
    async def hover(parameters: types.HoverParams) -> types.Hover | None:
        document = server.workspace.get_text_document(parameters.text_document.uri)
        text = meaning(document.source, document.offset_at_position(parameters.position))
        return types.Hover(types.MarkupContent(types.MarkupKind.Markdown, text)) if text else None

    return server


def _begun(text: str, offset: int) -> int:
    """How many characters of a word are typed in front of an offset; a word is of ASCII."""
    start = offset
    while start > 0 and (text[start - 1].isascii() and (text[start - 1].isalnum() or text[start - 1] in "_:.-@")):
        start -= 1
    return offset - start


def _item(one: Completion, where: types.Range) -> types.CompletionItem:
    from lsprotocol import types

    kinds = {"element": types.CompletionItemKind.Class, "attribute": types.CompletionItemKind.Property}
    return types.CompletionItem(
        one.label,
        kind=kinds.get(one.kind, types.CompletionItemKind.Value),
        detail=one.detail or None,
        documentation=types.MarkupContent(types.MarkupKind.Markdown, one.help) if one.help else None,
        text_edit=types.TextEdit(where, one.label),
    )
