"""What ARCHITECTURE.md promises about imports, and rules of the code, checked on the syntax of all modules.

Counted are imports at the top of a module, inside functions, for type checkers only, and by name
(`import_module("libgz.x")`, `__import__`).
"""

import ast
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent

# From the bottom up; imports go downwards only, and not between packages of one row.
LAYERS = [
    ["_version"],
    ["base"],
    ["ode"],
    ["physics", "transport", "worldfile", "sdf"],
    ["interfaces"],
    ["clib", "simulation", "rendering"],
    ["legacy", "sdfworld"],
    ["models", "classic", "cxx"],
    ["classic_cxx"],
    ["front"],
    ["ros", "player"],
    ["convert", "recording", "reference", "view"],
    ["study"],
    ["gym", "sweep"],
    ["testing"],
    ["apps"],
    ["__main__"],
]
# The same inside libgz.classic.
CLASSIC_LAYERS = [
    ["names", "api"],
    ["math"],
    ["common"],
    ["msgs"],
    ["transport"],
    ["event", "sdf"],
    ["plugin_base", "ros_names"],
    ["loading"],
    ["physics"],
    ["rendering"],
    ["sensors"],
    ["looks"],
    ["describe"],
    ["commands", "user_commands"],
    ["topics", "world_plugins"],
    ["plugin_states"],
    ["server"],
    ["gui", "log"],
    ["plugin"],
    ["plugins"],
]
# Tables of "module" or "module:Class" whose rows are imported when they are first used: names that are no literals.
TABLES = {
    "libgz.base.exports",  # the names of stubs
    "libgz.apps.libgz",
    "libgz.classic",
    "libgz.classic.sensors.kinds",
    "libgz.legacy.factory",
    "libgz.reference.classic_api",
    "libgz.ros.bridge.build_messages",  # both run in a Python of ROS 2
    "libgz.ros.bridge.program",
    "libgz.reference.classic_pages",
    "libgz.rendering.gl",  # PyOpenGL's declarations, by versions
    "libgz.sweep.worker",  # the modules that a run has loaded
}
# Circles inside a package are between a parent and its parts: without the parent there is none.
PARENTS = {
    "libgz.classic.rendering.scene",
    "libgz.physics.body",  # of geoms and joints
    "libgz.simulation.world",
    "libgz.classic.physics.world",
}


def module_name(path):
    parts = path.relative_to(ROOT).with_suffix("").parts
    parts = parts if parts[0] == "libgz" else ("libgz", *parts)
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


@cache
def modules():
    paths = [p for folder in ("libgz", "interfaces", "models") for p in (ROOT / folder).rglob("*.py")]
    return {module_name(path): path for path in paths}


@dataclass
class Facts:
    """What is in a module's syntax, in one walk, which takes longer than all questions about it."""

    imports: set = field(default_factory=set)
    named: set = field(default_factory=set)  # names given to import_module and __import__; None for no literal
    functions: set = field(default_factory=set)
    called: set = field(default_factory=set)
    unwanted: list = field(default_factory=list)  # (kind, line)


@cache
def facts_of(module):
    found = Facts()
    for node in ast.walk(ast.parse(modules()[module].read_text())):
        if isinstance(node, ast.Import):
            found.imports |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{module}:{node.lineno}: a relative import"
            names = {f"{node.module}.{alias.name}" for alias in node.names}
            found.imports |= {name if name in modules() else node.module for name in names}
        elif isinstance(node, ast.Call):
            called = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
            if called in ("import_module", "__import__", "resolve_name"):
                literal = node.args and isinstance(node.args[0], ast.Constant)
                found.named.add(node.args[0].value if literal else None)
            if isinstance(node.func, ast.Name):
                found.called.add(called)
                if called == "print":
                    found.unwanted.append((called, node.lineno))
        elif isinstance(node, ast.FunctionDef):
            found.functions.add(node.name)
        elif isinstance(node, ast.Assert):
            found.unwanted.append(("assert", node.lineno))
        elif isinstance(node, ast.ExceptHandler) and node.type is None:
            found.unwanted.append(("bare except", node.lineno))
        elif isinstance(node, ast.Attribute) and node.attr in ("executable", "_base_executable"):
            found.unwanted.append(("executable", node.lineno))
    return found


def imports_of(module):
    """Modules of libgz that a module imports anywhere in its text."""
    facts = facts_of(module)
    found = facts.imports | {name.partition(":")[0] for name in facts.named if name}
    return sorted(name for name in found if name.partition(".")[0] == "libgz")


def level_of(layers):
    return {name: level for level, row in enumerate(layers) for name in row}


def part_of(module, depth):
    return module.split(".")[depth] if module.count(".") >= depth else None


@pytest.mark.parametrize(("layers", "depth"), [(LAYERS, 1), (CLASSIC_LAYERS, 2)], ids=["libgz", "libgz.classic"])
def test_imports_go_downwards_only(layers, depth):
    level = level_of(layers)
    inside = "libgz.classic." if depth == 2 else "libgz."
    wrong = []
    for module in modules():
        part = part_of(module, depth) if module.startswith(inside) else None
        for imported in imports_of(module) if part else ():
            other = part_of(imported, depth) if imported.startswith(inside) else None
            if other and other != part and level[other] >= level[part]:
                wrong.append(f"{module} imports {imported}")
    assert not wrong


def test_nothing_below_imports_the_facades():
    facades = {"libgz", "libgz.classic"}
    wrong = [
        f"{module} imports {imported}"
        for module in modules()
        for imported in imports_of(module)
        if imported in facades
        and module not in facades
        and not module.startswith(("libgz.classic.plugins", "libgz.apps"))
    ]
    assert not wrong


def test_names_that_are_no_literals_are_imported_by_tables_only():
    assert {module for module in modules() if None in facts_of(module).named} <= TABLES


def circles(graph):
    """Sets of nodes that reach each other (Tarjan's algorithm)."""
    index, low, stack, found = {}, {}, [], []

    def visit(node):
        index[node] = low[node] = len(index)
        stack.append(node)
        for other in graph[node]:
            if other not in index:
                visit(other)
                low[node] = min(low[node], low[other])
            elif other in stack:
                low[node] = min(low[node], index[other])
        if low[node] == index[node]:
            circle = set()
            while node not in circle:
                circle.add(stack.pop())
            if len(circle) > 1:
                found.append(sorted(circle))

    for node in graph:
        if node not in index:
            visit(node)
    return found


def graph_without(left_out=()):
    kept = [module for module in modules() if module not in left_out]
    return {module: [other for other in imports_of(module) if other in kept] for module in kept}


def test_circles_stay_inside_a_package():
    for circle in circles(graph_without()):
        assert len({module.rpartition(".")[0] for module in circle}) == 1, circle


def test_circles_are_between_a_parent_and_its_parts():
    assert circles(graph_without(PARENTS)) == []
    for parent in PARENTS:
        assert any(parent in circle for circle in circles(graph_without(PARENTS - {parent}))), f"{parent} has no circle"


def test_only_one_package_touches_libode():
    for module, path in modules().items():
        assert module.startswith("libgz.ode") or "libode.so" not in path.read_text(), module


def places_of(kinds, apart_from):
    """Where modules do what they must not."""
    return [
        f"{module}:{line}: {kind}"
        for module in modules()
        if not module.startswith(apart_from)
        for kind, line in facts_of(module).unwanted
        if kind in kinds
    ]


def test_the_library_neither_prints_nor_asserts_nor_swallows():
    assert places_of(("assert", "bare except"), ()) == []
    assert places_of(("print",), "libgz.apps") == []


def test_one_place_starts_python():
    assert places_of(("executable",), "libgz.base.python") == [], "use libgz.base.python.start_module"


def test_commands_that_run_modules_are_only_written_into_scripts():
    """All others are started by `start_module`, with an environment of which nothing is the current directory."""
    users = {name for name, path in modules().items() if "run_module(" in path.read_text()}
    assert users == {"libgz.base.python", "libgz.ros.install", "libgz.ros.install2"}


def test_checks_that_only_warn_run_under_advise():
    """`advise` is the one place where they run: no module of the package calls a `warn_of_...` of another one."""
    for module in modules():
        facts = facts_of(module)
        assert not [n for n in facts.called - facts.functions if n.startswith("warn_of_")], module


@pytest.mark.parametrize(
    "text", ["import libgz.apps", "from libgz.apps.gazebo import main", "import_module('libgz.apps')"]
)
@pytest.mark.parametrize("place", ["{}", "def f():\n    {}", "if TYPE_CHECKING:\n    {}"])
def test_every_kind_of_import_is_seen(monkeypatch, tmp_path, text, place):
    path = tmp_path / "x.py"
    path.write_text(place.format(text))
    monkeypatch.setitem(modules(), "libgz.physics.x", path)
    assert [name.startswith("libgz.apps") for name in imports_of("libgz.physics.x")] == [True]
    facts_of.cache_clear()
