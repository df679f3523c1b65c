"""The documents as a whole: the navigation is complete, links lead somewhere, all generated pages can be built."""

import argparse
import importlib.util
import inspect
import os
import re
import shlex
import shutil
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest
from lxml import etree, html

from libgz.apps.api_pages import api_names
from libgz.apps.command_line import command_parsers
from libgz.apps.libgz import COMMANDS
from libgz.apps.ros_option import without_ros_words
from libgz.interfaces.catalog import INTERFACES
from libgz.legacy.settings import QUIRKS, GlobalAttributes
from libgz.models import MODELS
from libgz.reference.catalogue import rows_of
from libgz.reference.classic_pages import classic_pages
from libgz.reference.markdown import cell
from libgz.reference.sdf_elements import NO_EFFECT, rows_of_sdf, without_effect
from libgz.sdf.reader import SdfFile

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = sorted([*ROOT.glob("*.md"), *DOCS.rglob("*.md"), *(ROOT / "examples").rglob("*.md")])
LINK = re.compile(r"(?<!\\)\]\(([^)\s]+)\)")
NAMED = re.compile(r"(?<![\w/])(?:benchmarks|scripts|tests)/[\w/.-]+\.(?:py|sh|c)\b")  # files of the project in a text
HEADING = re.compile("#+ ")
BUILD = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-c", str(DOCS)]


def module(path):
    spec = importlib.util.spec_from_file_location(path.stem, path)
    found = importlib.util.module_from_spec(spec)
    sys.modules[path.stem] = found  # dataclasses look there
    spec.loader.exec_module(found)
    return found


def make_docs():
    return module(ROOT / "scripts" / "make_docs.py")


def without_code(text):
    return re.sub(r"`[^`\n]*`", "", re.sub(r"^```.*?^```", "", text, flags=re.S | re.M))


def anchors(page):
    """The anchors of a page's headings, as GitHub and the site make them."""
    headings = re.findall(r"^#+ (.*)$", re.sub(r"^```.*?^```", "", page.read_text(), flags=re.S | re.M), re.M)
    return {re.sub(r"[^\w -]", "", heading).strip().lower().replace(" ", "-") for heading in headings}


def test_the_navigation_has_every_page():
    """Each page is listed in docs/README.md, or in a README that is: at the beginning of a list item or table row."""
    entry = module(DOCS / "conf.py").ENTRY
    listed, waiting = {DOCS / "README.md"}, [DOCS / "README.md"]
    while waiting:
        page = waiting.pop()
        for line in page.read_text().splitlines():
            if (found := entry.match(line)) is not None:
                target = (page.parent / found[2]).resolve()
                if target not in listed:
                    listed.add(target)
                    if target.name == "README.md":
                        waiting.append(target)
    missing = [str(page.relative_to(ROOT)) for page in PAGES if page not in listed and page != ROOT / "README.md"]
    assert not missing, f"add them to docs/README.md: {missing}"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_somewhere(page):
    for link in LINK.findall(without_code(page.read_text())):
        if "://" in link:
            continue
        path, _, anchor = link.partition("#")
        target = (page.parent / path).resolve() if path else page
        assert target.exists(), link
        assert not anchor or anchor in anchors(target), link


def test_files_that_pages_name_exist():
    named = [(page, name) for page in PAGES for name in NAMED.findall(page.read_text())]
    assert not [(str(page), name) for page, name in named if not (ROOT / name).exists()]
    assert len(named) > 10


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    """What the site is built from: the hand-written pages and all generated ones."""
    folder = tmp_path_factory.mktemp("source") / "docs"
    make_docs().write_source(folder)
    return folder


@pytest.fixture(scope="module")
def site(tmp_path_factory, source):
    """The site, which is built without a warning and without a network."""
    folder = tmp_path_factory.mktemp("site")
    words = [*BUILD, str(source), "-d", str(folder / "trees"), str(folder / "site")]
    done = subprocess.run(words, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    return folder / "site"


@pytest.mark.trial
def test_the_site_has_no_broken_link_and_nothing_from_elsewhere(site):
    ids, links = {}, []
    for page in sorted(site.rglob("*.html")):
        tree = html.parse(page)
        ids[page] = {element.get("id") for element in tree.iter() if element.get("id")}
        for element in tree.iter("a", "img", "script", "link"):
            link = element.get("href") or element.get("src") or ""
            if element.tag != "a":
                assert "://" not in link, f"{page}: {link} is loaded from elsewhere"
            if link and "://" not in link and not link.startswith(("data:", "mailto:")):
                links.append((page, link.partition("?")[0]))
    assert len(ids) > 80
    for page, link in links:
        path, _, anchor = link.partition("#")
        target = (page.parent / path).resolve() if path else page
        assert target.exists(), (page, link)
        assert not anchor or target not in ids or anchor in ids[target], (page, link)
    assert (site / "docs" / "README.html").exists()
    assert "docs/README.html" in (site / "index.html").read_text()


def test_the_pages_have_no_warnings(tmp_path, source):
    """All written by hand, and some of each kind of the generated ones; of the others, the trial above builds more."""
    short = tmp_path / "short"
    shutil.copytree(source, short)
    folders = Counter()
    for name in sorted(make_docs().generated_pages()):
        page = short / "docs" / name
        folders[page.parent] += 1
        if page.name != "README.md":  # of the rest only headings, which others' links need
            lines = page.read_text().splitlines()
            whole = 60 if folders[page.parent] <= 2 else 0
            page.write_text("\n".join([*lines[:whole], "", *filter(HEADING.match, lines[whole:])]))
    command = [*BUILD, str(short), "-b", "dummy", "-d", str(tmp_path / "trees"), str(tmp_path / "site")]
    done = subprocess.run(command, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")


def test_all_generated_pages_are_built_and_none_is_committed(source):
    pages = make_docs().generated_pages()
    assert len(pages) > 200
    assert {"commands.md", "sdf_elements.md", "structs.md", "api/errors.md", "classic/physics/Link.md"} <= pages.keys()
    for name, text in pages.items():
        assert (source / "docs" / name).read_text() == text
        assert text.startswith("# ") or "\n# " in text, name
        assert not (DOCS / name).exists(), name
    for page in sorted((source / "docs" / name).resolve() for name in pages):
        for link in LINK.findall(without_code(page.read_text())):
            assert "://" in link or (page.parent / link.partition("#")[0]).exists(), (page, link)


def test_pages_that_list_names_have_all():
    """The pages name what `libgz help` and `libgz models` print in full."""
    api = {name for names in api_names().values() for name, thing in names.items() if inspect.isclass(thing)}
    classes = {Path(page).stem for page in classic_pages() if not page.endswith(("README.md", "names.md"))}
    lists = {
        "models.md": MODELS,
        "interfaces.md": INTERFACES,
        "api.md": {name for name in api if not name.endswith("Data")},
        "classic.md": classes,
    }
    for page, names in lists.items():
        text = (DOCS / page).read_text()
        assert not [name for name in names if f"`{name}`" not in text], page
    tools = (DOCS / "tools.md").read_text()
    assert not [name for name in COMMANDS if not re.search(rf"`libgz {name}\b", tools)]


def test_the_page_of_worldfiles_has_all_settings_and_quirks():
    text = (DOCS / "worldfile.md").read_text()
    for row in rows_of(GlobalAttributes):
        assert f"| `{row.name}` | {row.type} | {row.default} | {row.unit} | {cell(row.meaning)} |" in text
    for name, effect in QUIRKS.items():
        assert f"| `{name}` | {cell(effect)} |" in text


def test_the_gallery_is_current():
    gallery = module(ROOT / "scripts" / "make_gallery.py")
    before = {path: path.read_text() for path in (DOCS / "worlds.md", DOCS / "README.md")}
    try:
        gallery.write_text(gallery.all_entries())
        assert all(path.read_text() == text for path, text in before.items()), "run scripts/make_gallery.py --text"
    finally:
        for path, text in before.items():
            if path.read_text() != text:
                path.write_text(text)


def test_what_the_sdf_page_calls_without_effect_exists_and_the_rest_is_known_to_the_code():
    rows = rows_of_sdf()
    assert set(NO_EFFECT) <= set(rows)
    places = ("sdf", "sdfworld", "classic", "simulation", "rendering", "physics", "view", "apps")
    code = "".join(path.read_text() for place in places for path in (ROOT / "libgz" / place).rglob("*.py"))
    words = {word for text in re.findall(r"[\"']([\w ]+)[\"']", code) for word in text.split()}
    unknown = [path for path in rows if re.split("[/@]", path)[-1] not in words and not path.endswith("*")]
    assert [path for path in unknown if without_effect(path) is None] == []


# Commands ------------------------------------------------------------------------------------------------------------

COMMAND = re.compile(r"(?:\w+=\S+ )*(gazebo|gzserver|gzclient|libgz) (.*)")
ELLIPSES = re.compile(r"\[|\.\.\.|<|[A-Z]{2,}|\bID\b|\bV\b")


def shown_commands(page):
    """(line, words) of each command of libgz in the code of a page, with all its words."""
    inside = False
    for number, line in enumerate(page.read_text().splitlines(), 1):
        if line.startswith("```"):
            inside = not inside
        if not (inside or line.startswith("    ")):
            continue
        text = re.split(r"\s#\s|\s\s+\S*[a-z]| > | 2>|&$| \| | && ", line.strip().removeprefix("$ "))[0]
        if (found := COMMAND.fullmatch(text.strip())) is not None and not ELLIPSES.search(found[2]):
            yield number, shlex.split(found[1] + " " + found[2])


def test_all_commands_can_be_parsed():
    parsers, checked = command_parsers(), 0
    for page in PAGES:
        for number, (name, *words) in shown_commands(page):
            try:
                _, unknown = parsers[name].parse_known_args(without_ros_words(words))
            except (SystemExit, argparse.ArgumentError) as error:
                if isinstance(error, SystemExit) and not error.code:
                    continue  # -h
                raise AssertionError(f"{page.relative_to(ROOT)}:{number}: {name} {shlex.join(words)}") from None
            allowed = ("--frames-to", "--every")  # of plugins
            unknown = [word for word in unknown if not word.startswith(allowed)]
            assert not unknown, f"{page.relative_to(ROOT)}:{number}: {unknown}"
            checked += 1
    assert checked > 60


def test_make_docs_builds_the_same():
    recipe = (ROOT / "Makefile").read_text().partition("\ndocs: setup\n")[2].partition("\n\n")[0]
    assert "scripts/make_docs.py build/docs" in recipe
    assert "sphinx-build -q -W --keep-going -E -a -c docs build/docs build/site" in recipe
    assert os.access(DOCS / "conf.py", os.R_OK)


# XML -----------------------------------------------------------------------------------------------------------------


def xml_blocks():
    for page in PAGES:
        text = page.read_text()
        for block in re.finditer(r"^```xml\n(.*?)^```", text, re.S | re.M):
            yield pytest.param(block[1], id=f"{page.relative_to(ROOT)}:{text.count(chr(10), 0, block.start()) + 2}")


@pytest.mark.parametrize("text", list(xml_blocks()))
def test_xml_is_well_formed_and_sdf_has_no_errors(text):
    declared = 'xmlns:model="m" xmlns:param="p" xmlns:gz="g"'
    etree.fromstring(f"<all {declared}>{re.sub(r'<[?].*?[?]>', '', text)}</all>".encode())
    if text.startswith(("<sdf", "<?xml")) and "<sdf" in text:
        file = SdfFile.from_string(text)
        assert file.diagnostics.errors == []
        assert file.diagnostics.warnings == []
