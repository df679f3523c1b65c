"""libgz lsp: a language server for worldfiles and SDF files, over standard input and output.

Texts are checked in a process of their own, so that none can disturb the server, and without their plugins.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import logging
import re
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

from libgz._version import __version__
from libgz.base.errors import LibraryError, ParameterError
from libgz.base.extras import install
from libgz.base.python import start_module
from libgz.base.visible import visible
from libgz.reference.language import Completion, completions, meaning

if TYPE_CHECKING:
    from collections.abc import Mapping
    from io import RawIOBase

    from lsprotocol import types
    from pygls.lsp.server import LanguageServer
    from pygls.workspace import PositionCodec, TextDocument

__all__ = ["configure", "new_server", "run"]

log = logging.getLogger("libgz.lsp")

SOURCE = "libgz"
DELAY = 0.3  # [s] after the last change, until a text is checked
PATIENCE = 60.0  # [s] for a check
LONGEST = 16 << 20  # characters of a text that is checked and completed
LONGEST_HEADER = 1024  # bytes of a line
MOST_HEADERS = 100  # lines before a message
LONGEST_MESSAGE = 128 << 20  # bytes
MOST_CHECKS = 4  # at a time
MOST_SHOWN = 500  # diagnostics of a file
LONGEST_LINE = 10_000  # characters of a line in which something is marked
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
        ParameterError: what it sends are no messages.
        LibraryError: the extra is not installed.
    """
    server = new_server(trust=options.trust)
    handler = logging.StreamHandler()
    handler.setFormatter(_OneLine())
    logger = logging.getLogger("pygls")
    logger.addHandler(handler)
    logger.propagate = False
    with open(sys.stdout.fileno(), "wb", buffering=0, closefd=False) as output:  # nothing is left to write at the end
        server.start_io(_Input(sys.stdin.buffer), _Output(output))  # type: ignore[arg-type]  # they have what is used
    return 0


class _OneLine(logging.Formatter):
    """Records without tracebacks: what an editor sends is not trusted to be right."""

    def format(self, record: logging.LogRecord) -> str:
        text = record.getMessage().partition("\n")[0]
        if record.exc_info and (error := record.exc_info[1]) is not None:
            text = f"{text}: {error or type(error).__name__}"
        return visible(f"libgz: {' '.join(text.split())[:LONGEST_HEADER]}")


class _Input:
    """Standard input, of which no more is held than one message."""

    def __init__(self, stream: BinaryIO) -> None:
        self._stream = stream
        self._headers = 0  # since the last message

    def readline(self) -> bytes:
        """A line of a header.

        Raises:
            ParameterError: it is too long, or one of too many.
        """
        self._headers += 1
        if self._headers > MOST_HEADERS:
            raise ParameterError(f"the editor sends more than {MOST_HEADERS} lines of headers before a message")
        line = self._stream.readline(LONGEST_HEADER + 1)
        if len(line) > LONGEST_HEADER:
            raise ParameterError(f"the editor sends a header of more than {LONGEST_HEADER} bytes")
        return line

    def read(self, size: int) -> bytes:
        """A message.

        Raises:
            ParameterError: it is too long, or incomplete.
        """
        if size > LONGEST_MESSAGE:
            raise ParameterError(f"the editor sends a message of {size} bytes; {LONGEST_MESSAGE} are allowed")
        self._headers = 0
        data = self._stream.read(size)
        if len(data) < size:
            raise ParameterError(f"the editor ended after {len(data)} of {size} bytes of a message")
        return data


class _Output:
    """Standard output, until nobody reads it."""

    def __init__(self, stream: RawIOBase) -> None:
        self._stream = stream
        self._open = True

    def write(self, data: bytes) -> None:
        """Write all of a message, or nothing after the editor has ended."""
        try:
            while self._open and data:
                data = data[self._stream.write(data) or 0 :]
        except OSError as error:
            self._open = False
            log.error("the editor reads no more: %s", error)

    def flush(self) -> None:
        """Nothing waits."""

    def close(self) -> None:
        """Write no more."""
        self._open = False


class _Checks:
    """Checks texts a moment after they change, and publishes what is found; one check of a text at a time."""

    def __init__(self, server: LanguageServer, trust: bool) -> None:
        self._server, self._trust = server, trust
        self._tasks: dict[str, asyncio.Task[None]] = {}
        self._places = asyncio.Semaphore(MOST_CHECKS)

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
        async with self._places:
            document = _opened(self._server, uri)
            if document is None:
                return
            text, version = document.source, document.version
            found = await self._diagnostics(Path(document.path), text)
        lines = [line[:LONGEST_LINE] for line in text.split("\n")]  # as libxml counts them
        shown = [_shown(one, lines, document.path, document.position_codec) for one in found[:MOST_SHOWN]]
        self._server.text_document_publish_diagnostics(types.PublishDiagnosticsParams(uri, shown, version))

    async def _diagnostics(self, path: Path, text: str) -> list[dict[str, Any]]:
        """What `libgz check` reports of a text."""
        words = ["check", "--json", "--stdin", *([] if self._trust else ["--untrusted"]), "--", str(path.absolute())]
        try:
            process = start_module(
                "libgz",
                *words,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                cwd=path.parent if path.parent.is_dir() else None,
            )
        except (OSError, ValueError) as error:  # the name may be too long, or have a null character
            return [_whole_file(f"the check failed: {error}")]
        # In a thread: where a loop ends while asyncio starts a process, it waits for it for ever.
        try:
            answer, errors = await asyncio.to_thread(_communicate, process, text.encode("utf-8", "replace"))
        except subprocess.TimeoutExpired:
            return [_whole_file(f"the check took longer than {PATIENCE:g} s and was ended")]
        finally:
            process.kill()  # of a check that is given up, which ends the thread, too
        try:
            found: list[dict[str, Any]] = json.loads(answer)
        except ValueError:
            return [_whole_file(errors.decode(errors="replace").strip() or "the check failed")]
        return found


def _opened(server: LanguageServer, uri: str) -> TextDocument | None:
    """What an editor shows of a file; None if it is too long, or not opened: no files are read that it only names."""
    texts: Mapping[str, TextDocument] = server.workspace.text_documents
    document = texts.get(uri)
    return document if document is not None and len(document.source) <= LONGEST else None


def _communicate(process: subprocess.Popen[bytes], text: bytes) -> tuple[bytes, bytes]:
    """What a process answers to a text; it has ended then.

    Raises:
        subprocess.TimeoutExpired: it took too long.
    """
    with process:
        try:
            return process.communicate(text, PATIENCE)
        finally:
            process.kill()


def _whole_file(message: str) -> dict[str, Any]:
    return {"file": "", "line": 0, "element": "", "message": message, "severity": "error", "included": 0}


def _shown(one: dict[str, Any], lines: list[str], path: str, codec: PositionCodec) -> types.Diagnostic:
    """A diagnostic of `libgz check`, for an editor; one of an included file is at the include, with its place."""
    from lsprotocol import types

    here = one["file"] in ("", path) or Path(one["file"]) == Path(path).absolute()
    number = max(int(one["line"] if here else one["included"]) - 1, 0)
    line = lines[number] if number < len(lines) else ""
    place = "" if here else f"{one['file']}:{one['line']}: "
    element = f"<{one['element']}>: " if one["element"] else ""
    severity = types.DiagnosticSeverity.Error if one["severity"] == "error" else types.DiagnosticSeverity.Warning
    if UNTRUSTED in one["message"]:
        severity = types.DiagnosticSeverity.Information
    start, end = _marked(line, one["element"] if here else "include")
    marked = types.Range(types.Position(number, start), types.Position(number, end))
    return types.Diagnostic(
        codec.range_to_client_units(lines, marked),
        f"{place}{element}{one['message']}",
        severity=severity,
        source=SOURCE,
        related_information=None if here else [_elsewhere(one, Path(path).parent)],
    )


def _elsewhere(one: dict[str, Any], folder: Path) -> types.DiagnosticRelatedInformation:
    """The place of a diagnostic in another file, which editors offer to open."""
    from lsprotocol import types

    place = types.Position(max(int(one["line"]) - 1, 0), 0)
    address = (folder / one["file"]).resolve().as_uri()
    return types.DiagnosticRelatedInformation(types.Location(address, types.Range(place, place)), one["message"])


def _marked(line: str, element: str) -> tuple[int, int]:
    """Where an element begins and ends in its line; the whole line where it is not there, or several of its name."""
    name = re.escape(element)
    tag = rf"<{name}(?![\w:.-])[^<>]*>?(?:[^<>]*</{name}\s*>)?"
    found = list(re.finditer(tag, line)) if element else []
    if len(found) == 1:
        return found[0].span()
    start = len(line) - len(line.lstrip())
    return start, max(len(line.rstrip()), start + 1)


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
    completing = asyncio.Lock()  # one at a time, in a thread: a long text takes seconds

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
        document = _opened(server, parameters.text_document.uri)
        if document is None:
            return types.CompletionList(is_incomplete=False, items=[])
        position = parameters.position
        offset = document.offset_at_position(position)
        begun = _begun(document.source, offset)
        start = types.Position(position.line, max(position.character - begun, 0))
        async with completing:
            found = await asyncio.to_thread(completions, document.source, offset)
        items = [_item(one, types.Range(start, position)) for one in found]
        return types.CompletionList(is_incomplete=False, items=items)

    @server.feature(types.TEXT_DOCUMENT_HOVER)
    async def hover(parameters: types.HoverParams) -> types.Hover | None:
        document = _opened(server, parameters.text_document.uri)
        if document is None:
            return None
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
