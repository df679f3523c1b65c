"""The language server, spoken to by a client of the protocol over its standard input and output."""

import asyncio
import contextlib
import json
import subprocess

import pytest
from lsprotocol import types
from pygls.lsp.client import LanguageClient

from libgz.base.python import run_module

LEGACY = """<?xml version="1.0"?>
<gz:world xmlns:gz="http://playerstage.sourceforge.net/gazebo/xmlschema/#gz"
  xmlns:model="http://playerstage.sourceforge.net/gazebo/xmlschema/#model">
  <model:SimpleSolid>
    <id>b</id>
    <sise>1 1 1</sise>
  </model:SimpleSolid>
</gz:world>
"""
SDF = """<sdf version="1.6">
<world name="w">
<model name="m"><link name="l"><inertial><mass>heavy</mass></inertial></link></model>
</world>
</sdf>
"""
PLUGIN = """from pathlib import Path
Path(__file__).with_name("ran").touch()
"""


class Editor:
    """A client that keeps the diagnostics that it receives."""

    def __init__(self):
        self.client = LanguageClient("test", "1")
        self.received = asyncio.Queue()

        @self.client.feature(types.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS)
        def take(parameters):
            self.received.put_nowait(parameters)

    async def open(self, path, text):
        document = types.TextDocumentItem(path.as_uri(), "xml", 1, text)
        self.client.text_document_did_open(types.DidOpenTextDocumentParams(document))
        return await self.diagnostics()

    async def change(self, path, text, version=2):
        document = types.VersionedTextDocumentIdentifier(uri=path.as_uri(), version=version)
        changes = [types.TextDocumentContentChangeWholeDocument(text)]
        self.client.text_document_did_change(types.DidChangeTextDocumentParams(document, changes))
        return await self.diagnostics()

    async def diagnostics(self):
        found = await asyncio.wait_for(self.received.get(), 120)
        return found.diagnostics


@contextlib.asynccontextmanager
async def editor():
    one = Editor()
    await one.client.start_io(*run_module("libgz", "lsp"))
    try:
        await one.client.initialize_async(types.InitializeParams(types.ClientCapabilities()))
        one.client.initialized(types.InitializedParams())
        yield one
    finally:
        await one.client.shutdown_async(None)
        one.client.exit(None)
        await one.client.stop()


async def errors_completions_and_meanings(path, text, wrong, right, begun, offered):
    document = types.TextDocumentIdentifier(path.as_uri())
    line = next(number for number, one in enumerate(text.splitlines()) if wrong in one)
    async with editor() as one:
        found = await one.open(path, text)
        assert [error.range.start.line for error in found] == [line]
        assert found[0].source == "libgz"
        fixed = text.replace(wrong, right)
        assert list(await one.change(path, fixed)) == []
        await one.change(path, fixed.replace(right, begun), 3)
        column = fixed.replace(right, begun).splitlines()[line].index(begun) + len(begun)
        place = types.Position(line, column)
        listed = await one.client.text_document_completion_async(types.CompletionParams(document, place))
        item = next(one for one in listed.items if one.label == offered)
        assert item.text_edit.range.start.character == column - len(begun.lstrip("<"))
        await one.change(path, fixed, 4)
        column = fixed.splitlines()[line].index(f"<{offered}>") + 2
        place = types.Position(line, column)
        shown = await one.client.text_document_hover_async(types.HoverParams(document, place))
        assert f"**{offered}**" in shown.contents.value
        closed = types.DidCloseTextDocumentParams(document)
        one.client.text_document_did_close(closed)
        assert list(await one.diagnostics()) == []


@pytest.mark.parametrize(
    ("name", "text", "wrong", "right", "begun", "offered"),
    [
        ("my.world", LEGACY, "sise", "size", "<siz", "size"),
        ("my.sdf", SDF, "<mass>heavy", "<mass>3", "<ma", "mass"),
    ],
)
def test_errors_are_shown_while_a_text_is_typed(tmp_path, name, text, wrong, right, begun, offered):
    path = tmp_path / name  # the file need not be there: the editor's text counts
    if wrong == "sise":
        right, wrong = "<size>1 1 1</size>", "<sise>1 1 1</sise>"
    asyncio.run(errors_completions_and_meanings(path, text, wrong, right, begun, offered))


async def first_answer(long, short):
    """The file whose request is answered first: a completion in a long text, or what is asked then of a short one."""
    async with editor() as one:
        await one.open(long, "<sdf version='1.6'>" + 500_000 * "<a>" + "\n<")
        await one.open(short, SDF)
        answered = []

        async def ask(request, kind, path, place):
            await request(kind(types.TextDocumentIdentifier(path.as_uri()), place))
            answered.append(path)

        client = one.client
        await asyncio.gather(
            ask(client.text_document_completion_async, types.CompletionParams, long, types.Position(1, 1)),
            ask(client.text_document_hover_async, types.HoverParams, short, types.Position(2, 3)),
        )
        return answered[0]


def test_a_completion_in_a_long_text_keeps_no_other_request_waiting(tmp_path):
    assert asyncio.run(first_answer(tmp_path / "long.sdf", tmp_path / "short.sdf")).name == "short.sdf"


async def diagnostics_of(path, text):
    async with editor() as one:
        return await one.open(path, text)


def test_no_plugin_of_a_text_runs(tmp_path):
    (tmp_path / "evil.py").write_text(PLUGIN)
    text = LEGACY.replace("<sise>1 1 1</sise>", "<plugin>evil.py</plugin>").replace("SimpleSolid", "Evil")
    found = asyncio.run(diagnostics_of(tmp_path / "my.world", text))
    assert not (tmp_path / "ran").exists()
    assert [one.severity for one in found] == [types.DiagnosticSeverity.Information]


TWO = 2 * "<collision name='c'><max_contacts>many</max_contacts></collision>"  # which one it is is not known


@pytest.mark.parametrize(
    ("before", "marked", "after"),
    [
        ("<link name='😀'><inertial>", "<mass>heavy</mass>", "</inertial></link>"),
        ("<link name='l'><inertial>", "<mass>", "heavy\n</mass></inertial></link>"),
        ("<link name='l'><inertial>", "<mass >heavy</mass >", "<massive/></inertial></link>"),
        ("<link name='l'>\n", TWO, "\n</link>"),
    ],
)
def test_an_element_is_marked_in_its_line(tmp_path, before, marked, after):
    text = f"<sdf version='1.6'>\n <model name='m'>\n  {before}{marked}{after}\n </model>\n</sdf>"
    found = asyncio.run(diagnostics_of(tmp_path / "my.sdf", text))
    [place, *_] = [one.range for one in found if "must be" in one.message]
    assert place.start.line == place.end.line
    line = text.splitlines()[place.start.line].encode("utf-16-le")  # the protocol counts by its units
    assert line[2 * place.start.character : 2 * place.end.character].decode("utf-16-le") == marked


def test_what_is_wrong_in_an_included_file_is_shown_at_the_include(tmp_path):
    inner, outer = tmp_path / "inner", tmp_path / "outer"
    for folder, text in (
        (inner, "<link name='l'>\n<inertial><mass>heavy</mass></inertial></link>"),
        (outer, "\n\n\n\n<include><uri>../inner</uri></include>"),
    ):
        folder.mkdir()
        folder.joinpath("model.config").write_text("<model><name>m</name><sdf version='1.6'>model.sdf</sdf></model>")
        folder.joinpath("model.sdf").write_text(f"<sdf version='1.6'><model name='m'>{text}</model></sdf>")
    text = "<sdf version='1.6'>\n<world name='w'>\n  <include>\n<uri>outer</uri></include></world></sdf>"
    [error] = asyncio.run(diagnostics_of(tmp_path / "my.world", text))
    assert error.range == types.Range(types.Position(2, 2), types.Position(2, len("  <include>")))
    assert error.message.startswith(f"{outer / '../inner/model.sdf'}:2: <mass>: ")
    [related] = error.related_information
    assert related.location.uri == (inner / "model.sdf").as_uri()
    assert related.location.range.start == types.Position(1, 0)


def test_a_text_without_a_file_is_no_other_file():
    async def diagnostics():
        async with editor() as one:
            document = types.TextDocumentItem("untitled:Untitled-1", "xml", 1, "<sdf version='1.6'>\n <world/></sdf>")
            one.client.text_document_did_open(types.DidOpenTextDocumentParams(document))
            return await one.diagnostics()

    [error] = asyncio.run(diagnostics())
    assert error.message.startswith("<world>: ")
    assert error.range.start == types.Position(1, 1)
    assert error.related_information is None


def test_what_is_no_xml_is_an_error_of_its_line(tmp_path):
    found = asyncio.run(diagnostics_of(tmp_path / "my.world", "<gz:world xmlns:gz='x'>\n<model"))
    assert found
    assert {one.severity for one in found} == {types.DiagnosticSeverity.Error}


def framed(body):
    return b"Content-Length: %d\r\n\r\n%b" % (len(body), body)


def message(name, number=None, **more):
    number = {} if number is None else {"id": number}
    return framed(json.dumps({"jsonrpc": "2.0", "method": name} | number | more).encode())


INITIALIZE = message("initialize", 1, params={"processId": None, "rootUri": None, "capabilities": {}})


def served(sent, **options):
    """What a server does that an editor sends this."""
    return subprocess.run(run_module("libgz", "lsp"), input=sent, capture_output=True, timeout=60, **options)


def test_the_server_ends_as_its_editor_says(tmp_path):
    ended = served(INITIALIZE + message("shutdown", 2, params=None) + message("exit"), cwd=tmp_path)
    assert ended.stderr == b""
    assert ended.returncode == 0


@pytest.mark.parametrize(
    ("sent", "error"),
    [
        (b"Content-Length: 100\r\n\r\n{}", b"the editor ended after 2 of 100 bytes of a message"),
        (b"Content-Length: 40000000000\r\n\r\n{}", b"the editor sends a message of 40000000000 bytes; 134217728 are"),
        (b"X: y\r\n" * 1000 + b"\r\n", b"the editor sends more than 100 lines of headers"),
        (b"Content-Length: " + b"9" * 5000 + b"\r\n\r\n", b"the editor sends a header of more than 1024 bytes"),
    ],
)
def test_what_is_no_stream_of_messages_ends_the_server_with_a_sentence(sent, error):
    ended = served(sent)
    assert ended.stderr.startswith(b"libgz: " + error)
    assert ended.stderr.count(b"\n") == 1
    assert ended.returncode == 1


def test_wrong_messages_are_a_line_each_and_the_server_goes_on():
    place = {"textDocument": {"uri": "file:///dev/zero"}, "position": {"line": 0, "character": 0}}  # never opened
    sent = [framed(b"[" * 100_000), framed(b"5"), message("textDocument/hover", 2, params={"position": 5}), INITIALIZE]
    ended = served(
        b"".join(sent) + message("textDocument/hover", 3, params=place) + message("shutdown", 4, params=None)
    )
    assert ended.stderr
    assert all(line.startswith(b"libgz: Unable to ") for line in ended.stderr.splitlines())
    assert b'"id": 4' in ended.stdout
    assert ended.returncode == 0


def test_an_editor_that_reads_no_more_is_one_line():
    with subprocess.Popen(run_module("libgz", "lsp"), stdin=-1, stdout=-1, stderr=-1) as server:
        server.stdout.close()
        server.stdin.write(INITIALIZE * 3)
        server.stdin.close()
        said = server.stderr.read()
    assert b"the editor reads no more: " in said
    assert said.count(b"\n") == 1
    assert server.returncode == 0


def test_an_editor_that_ends_during_checks_leaves_no_traceback(tmp_path):
    process = subprocess.Popen(run_module("libgz", "lsp"), stdin=-1, stdout=-1, stderr=-1, cwd=tmp_path)
    opened = {"jsonrpc": "2.0", "method": "textDocument/didOpen"}
    messages = [{"jsonrpc": "2.0", "id": 1, "method": "initialize", "params": {"capabilities": {}}}]
    for number in range(12):
        document = {"uri": f"file://{tmp_path}/{number}.world", "languageId": "xml", "version": 1, "text": LEGACY}
        messages.append({**opened, "params": {"textDocument": document}})
    for body in map(str.encode, map(json.dumps, messages)):
        process.stdin.write(b"Content-Length: %d\r\n\r\n%s" % (len(body), body))
    process.stdin.flush()
    while b"publishDiagnostics" not in process.stdout.readline():
        pass
    _, errors = process.communicate(timeout=60)
    assert (process.returncode, errors) == (0, b"")
