"""Rewriting worldfiles of Gazebo 0.3 and 0.4 in the spelling of 0.5 to 0.7; comments and layout stay."""

from __future__ import annotations

import re
from collections.abc import Iterator

from libgz.base.errors import Remark
from libgz.base.geometry import GzCoordPoseAdd, GzPose, GzVector
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode
from libgz.worldfile.source import (
    Edit,
    Span,
    apply_edits,
    attribute_spans,
    element_spans,
    fill,
    indent_of,
    put_first,
    tag_of,
)
from libgz.worldfile.spelling import IMPLIED, Renamed, ignored_tags, renamed_keys, renamed_tags

__all__ = ["upgrade"]

VERSION = "0.5"
NAMESPACE = "http://playerstage.sourceforge.net/gazebo/xmlschema/#param"
_COMMENT = re.compile(rb"<!--.*?-->", re.DOTALL)


def upgrade(file: WorldFile) -> tuple[bytes, list[Remark]]:
    """The worldfile's bytes in the newer spelling, and the changes.

    Models of plugins keep their attributes: only their code defines the meaning of them. What a model reads of either
    file is the same to the last bit, and so is its motion.
    """
    work = _Upgrade(file)
    work.settings()
    for node in file.GetRootNode().walk():
        if node.prefix == "model":
            if "plugin" not in node.attributes and node.GetChild("plugin") is None:
                work.model(node)
            if file.is_old:
                work.implied(node)
                work.origin(node)
    source = work.apply()
    if file.is_old and _judged_old(source):
        source = _marked(source)
        work.note(
            file.GetRootNode(), f'marked as version="{VERSION}", because some of its models existed until 0.4 only'
        )
    return source, sorted(work.changes, key=lambda change: change.line)


def _marked(source: bytes) -> bytes:
    """The document with the current version in the root's tag."""
    root = element_spans(source)[0]
    end = root.content - (2 if root.empty else 1)
    older = attribute_spans(source, root).get(b"version")
    start, stop = older or (end, end)
    return source[:start] + (VERSION if older else f' version="{VERSION}"').encode() + source[stop:]


def _judged_old(source: bytes) -> bool:
    file = WorldFile()
    file.LoadString(source)
    return file.is_old


class _Upgrade:
    """The edits to one file."""

    def __init__(self, file: WorldFile) -> None:
        self.file = file
        self.source = file.source
        self.spans = element_spans(self.source)
        self.edits: list[Edit] = []
        self.changes: list[Remark] = []

    def note(self, node: WorldFileNode, message: str) -> None:
        self.changes.append(Remark(self.file.label, node.line, node.tag, message))

    def apply(self) -> bytes:
        """The source with all edits, except those inside a range that another edit removes."""
        kept: list[Edit] = []
        for edit in sorted(self.edits, key=lambda e: (e[0], e[1] > e[0], -e[1])):  # insertions before removals
            if not kept or edit[0] >= kept[-1][1]:
                kept.append(edit)
        return apply_edits(self.source, kept)

    # Edits -------------------------------------------------------------------------------------------------------

    def span(self, node: WorldFileNode) -> Span:
        return self.spans[node.number]

    def rename(self, node: WorldFileNode, tag: str) -> None:
        """Another tag, the same content."""
        span = self.span(node)
        length = len(tag_of(self.source, span))
        new = tag.encode(self.file.encoding)
        self.edits.append((span.start + 1, span.start + 1 + length, new))
        if not span.empty:
            self.edits.append((span.end + 2, span.end + 2 + length, new))

    def write(self, node: WorldFileNode, text: str, tag: str = "") -> None:
        """Another text; comments and the blanks around the old text stay. `tag` is the new tag, if there is one."""
        span = self.span(node)
        inside = self.source[span.content : span.end]
        comments = b"".join(b" " + comment for comment in _COMMENT.findall(inside))
        plain = _COMMENT.sub(b"", inside)
        before = plain[: len(plain) - len(plain.lstrip())]
        after = plain[len(plain.rstrip()) :] if plain.strip() else b""
        new = before + text.encode(self.file.encoding) + comments + after
        self.edits.append(fill(self.source, span, new, tag.encode(self.file.encoding)))

    def remove(self, node: WorldFileNode) -> None:
        """Remove an element, with its line if nothing else is on it; comments in it stay."""
        span = self.span(node)
        comments = _COMMENT.findall(self.source[span.content : span.end])
        if comments:
            self.edits.append((span.start, span.after, b" ".join(comments)))
        else:
            self.edits.append((*self._line(span.start, span.after), b""))

    def unwrap(self, node: WorldFileNode) -> None:
        """Replace an element by its content, indented as the element was."""
        span = self.span(node)
        self.edits.append((*self._line(span.start, span.content), b""))
        self.edits.append((*self._line(span.end, span.after), b""))
        depth = self._indent(self.span(node.children[0]).start) - self._indent(span.start)
        for match in re.finditer(rb"\n[ \t]*", self.source[span.content : span.end]):
            cut = min(depth, len(match.group()) - 1)
            if cut > 0:
                start = span.content + match.start() + 1
                self.edits.append((start, start + cut, b""))

    def add(self, node: WorldFileNode, tag: str, text: str) -> None:
        """A new first child."""
        span = self.span(node)
        child = f"<{tag}>{text}</{tag}>".encode(self.file.encoding)
        self.edits.append(put_first(self.source, span, indent_of(self.source, span) + child))

    def _line(self, start: int, end: int) -> tuple[int, int]:
        """The whole line if nothing else is on it, else the range itself."""
        line_start = self.source.rfind(b"\n", 0, start) + 1
        newline = self.source.find(b"\n", end)
        line_end = len(self.source) if newline < 0 else newline + 1
        alone = not self.source[line_start:start].strip() and not self.source[end:line_end].strip()
        return (line_start, line_end) if alone else (start, end)

    def _indent(self, start: int) -> int:
        line = self.source[self.source.rfind(b"\n", 0, start) + 1 : start]
        return len(line) if not line.strip() else 0

    # Rules -------------------------------------------------------------------------------------------------------

    def settings(self) -> None:
        """`params:GlobalParams` as `param:Global`; only the last of all such elements ever counted."""
        nodes = [node for node in self.file.GetRootNode().walk() if node.tag == "params:GlobalParams"]
        newer = any(node.tag == "param:Global" for node in self.file.GetRootNode().walk())
        for node in nodes if newer else nodes[:-1]:
            self.remove(node)
            self.note(node, "removed, because only the last element with settings has an effect")
        if nodes and not newer:
            self.rename(nodes[-1], "param:Global")
            self.note(nodes[-1], "renamed to <param:Global>")
            self._declare_prefix(nodes)

    def _declare_prefix(self, renamed: list[WorldFileNode]) -> None:
        """Declare the prefix `param`, by renaming `params` if nothing else uses it."""
        root = self.spans[0]
        tag = self.source[root.start : root.content]
        if re.search(rb"\sxmlns:param\s*=", tag):
            return
        declared = re.search(rb"\sxmlns:(params)\s*=", tag)
        others = [n for n in self.file.GetRootNode().walk() if n.prefix == "params" and n not in renamed]
        if declared and not others:
            self.edits.append((root.start + declared.start(1), root.start + declared.end(1), b"param"))
        else:
            end = root.content - (2 if root.empty else 1)
            self.edits.append((end, end, f' xmlns:param="{NAMESPACE}"'.encode()))

    def model(self, node: WorldFileNode) -> None:
        """All older tags of one model."""
        survivors: set[WorldFileNode] = set()
        wrappers: dict[WorldFileNode, None] = {}
        for key in renamed_keys(node.name):
            taken = key in node.attributes or any(c.name == key and c.prefix != "model" for c in node.children)
            for renamed in renamed_tags(node.name, key):
                for old in _all_at(node, renamed.path):
                    if len(renamed.path) > 1 and old.parent is not None:
                        wrappers.setdefault(old.parent)
                    if taken or old is not node.at(renamed.path):
                        self._drop(old, f"removed, because another <{key}> overrides it")
                    else:
                        self._rename(old, key, renamed)
                        survivors.add(old)
                        taken = True
        for path in ignored_tags(node.name):
            for old in _all_at(node, path):
                if any(longer[:-1] == path for longer in ignored_tags(node.name)):
                    wrappers.setdefault(old)
                else:
                    self._drop(old, "removed, because it has no effect since 0.5")
        for wrapper in wrappers:
            self._open(wrapper, survivors)

    def _open(self, wrapper: WorldFileNode, survivors: set[WorldFileNode]) -> None:
        """Move what still has an effect out of a `<window>` or `<lens>`."""
        if not any(child in survivors for child in wrapper.children):
            self._drop(wrapper, "removed, because nothing in it has an effect since 0.5")
            return
        noted = {(change.line, change.element) for change in self.changes}
        for child in wrapper.children:
            if child not in survivors and (child.line, child.tag) not in noted:
                self._drop(child, "removed, because it was never read")
        self.unwrap(wrapper)
        self.note(wrapper, "removed; its content is now in the model itself")

    def _drop(self, node: WorldFileNode, why: str) -> None:
        self.remove(node)
        self.note(node, why)

    def _rename(self, node: WorldFileNode, key: str, renamed: Renamed) -> None:
        self.rename(node, key)
        text = renamed.convert(node.content, self.file.step_time)
        if text != node.content:
            self.write(node, text, key)
            self.note(node, f"{node.content.strip()} is now <{key}> {text}")
        elif node.name != key:
            self.note(node, f"renamed to <{key}>")

    def implied(self, node: WorldFileNode) -> None:
        """Write what models of files of 0.4 have without naming it."""
        for key, text in IMPLIED.get(node.name, {}).items():
            if key not in node.attributes and not any(c.name == key and c.prefix != "model" for c in node.children):
                self.add(node, key, text)
                self.note(node, f"has <{key}> {text}, which models of 0.4 have without naming it")

    def origin(self, node: WorldFileNode) -> None:
        """Convert the pose of a model whose origin was elsewhere in 0.4."""
        own = self.file.origin_height(node)
        parent = node.parent
        of_parent = self.file.origin_height(parent) if parent is not None and parent.prefix == "model" else 0.0
        if not own and not of_parent:
            return
        given = GzPose(node.GetPosition("xyz"), node.GetRotation("rpy"))
        pose = GzCoordPoseAdd(GzPose(GzVector(0.0, 0.0, -own)), given)
        pose.pos.z += of_parent
        place = next((child for child in node.children if child.name == "xyz" and child.prefix != "model"), None)
        place = place or next(_all_at(node, ("pos",)), None)
        words = (node.attributes.get("xyz") or (place.content if place else "")).split()
        text = " ".join(
            _number(new, old, i, words) for i, (new, old) in enumerate(zip(pose.pos, given.pos, strict=True))
        )
        if "xyz" in node.attributes:
            value = attribute_spans(self.source, self.span(node))[b"xyz"]
            self.edits.append((*value, text.encode()))
        elif place is not None:
            self.write(place, text)
        else:
            self.add(node, "xyz", text)
        self.note(node, f"xyz is now {text}, because the origin of this model or of its parent has moved since 0.4")


def _number(new: float, old: float, index: int, words: list[str]) -> str:
    """A coordinate; as written in the file if it has not changed, else with as many digits as it takes."""
    if new == old and index < len(words):
        return words[index]
    short = f"{round(new, 9) + 0.0:.9f}".rstrip("0").rstrip(".")
    return short if float(short) == new else repr(new)


def _all_at(node: WorldFileNode, path: tuple[str, ...]) -> Iterator[WorldFileNode]:
    """All elements at a path of tags below a model."""
    for child in node.children:
        if child.name != path[0] or child.prefix == "model":
            continue
        if len(path) == 1:
            yield child
        else:
            yield from _all_at(child, path[1:])
