"""What the architecture page promises, checked mechanically."""

import ast
import subprocess
import sys
from pathlib import Path

import libgz

ROOT = Path(__file__).parent.parent
SOURCES = {
    **{
        p: "libgz." + ".".join(p.relative_to(ROOT / "libgz").with_suffix("").parts)
        for p in (ROOT / "libgz").rglob("*.py")
    },
    **{p: f"libgz.interfaces.{p.stem}" for p in (ROOT / "interfaces").glob("*.py")},
    **{p: f"libgz.models.{p.stem}" for p in (ROOT / "models").glob("*.py")},
}

# Who may import whom: downwards only. One row is one level.
LEVELS = [
    {"errors", "error", "files", "geometry", "ode", "_version"},
    {"physics", "worldfile", "sdf", "transport"},
    {"sensors", "rendering", "interfaces"},
    {"simulation", "clib"},
    {"models", "classic"},
    {"reference", "convert"},
    {"apps"},
]
LEVEL = {name: i for i, row in enumerate(LEVELS) for name in row}

# The same inside libgz.classic, for what a module needs when it is imported.
CLASSIC_LEVELS = [
    {"math"},
    {"common"},
    {"msgs"},
    {"transport"},
    {"plugin", "event", "sdf", "loading"},
    {"physics"},
    {"rendering"},
    {"sensors"},
    {"describe", "commands", "topics", "server"},
    {"gui", "plugins", "log"},
]
CLASSIC_LEVEL = {name: i for i, row in enumerate(CLASSIC_LEVELS) for name in row}


def imports_of(path):
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("libgz."):
            yield node.module.split(".")[1]
        elif isinstance(node, ast.Import):
            for alias in node.names:
                if alias.name.startswith("libgz."):
                    yield alias.name.split(".")[1]


def test_imports_go_downwards_only():
    wrong = []
    for path, module in SOURCES.items():
        package = module.split(".")[1]
        if package == "__init__":
            continue
        for imported in imports_of(path):
            sideways = LEVEL[imported] == LEVEL[package] and imported != package
            allowed_sideways = LEVEL[package] == 0 or (package, imported) in {("physics", "ode")}
            if LEVEL[imported] > LEVEL[package] or (sideways and not allowed_sideways):
                wrong.append(f"{module} imports libgz.{imported}")
    assert not wrong


def needs_of(path):
    """What a module imports at once: not for type checkers only, and not in a function."""
    for node in ast.parse(path.read_text()).body:
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("libgz.classic"):
            inside = node.module.split(".")[2:]
            yield from inside[:1] or (alias.name for alias in node.names)


def test_inside_classic_imports_go_downwards_too():
    wrong = []
    for path, module in SOURCES.items():
        room = [*module.split("."), "", ""][2]
        if module.startswith("libgz.classic.") and room != "__init__":
            above = [need for need in needs_of(path) if CLASSIC_LEVEL[need] > CLASSIC_LEVEL[room]]
            wrong += [f"{module} imports libgz.classic.{need}" for need in above]
    assert not wrong


def test_simulation_knows_neither_sensors_nor_rendering():
    for path, module in SOURCES.items():
        if module.startswith("libgz.simulation"):
            assert not {"sensors", "rendering"} & set(imports_of(path)), module


def test_only_one_package_touches_libode():
    for path, module in SOURCES.items():
        if not module.startswith("libgz.ode"):
            assert "libode.so" not in path.read_text(), module


def test_the_library_neither_prints_nor_asserts_nor_swallows():
    for path, module in SOURCES.items():
        for node in ast.walk(ast.parse(path.read_text())):
            where = f"{module}:{getattr(node, 'lineno', 0)}"
            assert not isinstance(node, ast.Assert), where
            assert not (isinstance(node, ast.ExceptHandler) and node.type is None), where
            is_print = isinstance(node, ast.Call) and getattr(node.func, "id", "") == "print"
            assert not is_print or module.startswith("libgz.apps"), where


def test_modules_are_small():
    paths = [*SOURCES, *(ROOT / "tests").glob("*.py")]
    long = {str(path): n for path in paths if (n := len(path.read_text().splitlines())) > 500}
    assert not long


def test_every_public_name_can_be_imported():
    for name in dir(libgz):
        assert getattr(libgz, name) is not None
    assert {"World", "Model", "Body", "HingeJoint", "Client", "GZ_REGISTER_PLUGIN", "dParamVel"} <= set(dir(libgz))


def test_a_star_import_brings_every_public_name():
    names = {}
    exec("from libgz import *", names)
    assert {"World", "gz_client_alloc", "gz_position_open", "GZ_SEM_KEY"} <= set(names)


def test_a_wrong_name_is_answered_with_the_right_one():
    try:
        _ = libgz.Wordl
    except AttributeError as error:
        assert "did you mean 'World'" in str(error)
    else:
        raise AssertionError("no error")


def loaded_after(statement):
    code = f"import sys\n{statement}\nprint(' '.join(sys.modules))"
    return set(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split())


def test_importing_the_package_loads_next_to_nothing():
    assert not {"numpy", "lxml", "ctypes", "OpenGL"} & loaded_after("import libgz")


def test_a_world_without_cameras_never_loads_opengl():
    world = ROOT / "worlds" / "pioneer2at.world"
    loaded = loaded_after(
        f"import libgz\nw = libgz.World.from_file({str(world)!r})\nw.step(20)\nw.close()\n"
        "print(open('/proc/self/maps').read())"
    )
    assert "libgz.simulation.world" in loaded
    assert not [name for name in loaded if name.startswith(("OpenGL", "libgz.rendering", "PIL"))]
    assert not [name for name in loaded if "libOSMesa" in name or "libEGL" in name or "libGL" in name]
