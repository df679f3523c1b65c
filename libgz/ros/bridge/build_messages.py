"""Builds packages of messages for a ROS 2 of published wheels, with the wheels' own generators and a C compiler.

It runs with the Python of that environment: ``build_messages.py FOLDER PACKAGE...``. Each package has its
definitions in FOLDER/PACKAGE/msg, srv and action; it is installed into the environment.
"""

from __future__ import annotations

import importlib
import os
import shutil
import subprocess
import sys
import sysconfig
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy

GENERATORS = {
    "rosidl_generator_c": "GenerateC",
    "rosidl_generator_py": "GeneratePython",
    "rosidl_typesupport_c": "GenerateCTypesupport",
    "rosidl_typesupport_fastrtps_c": "GenerateFastRTPSCTypesupport",
    "rosidl_typesupport_introspection_c": "GenerateIntrospectionCTypesupport",
}
SUPPORTS = ("rosidl_typesupport_c", "rosidl_typesupport_fastrtps_c", "rosidl_typesupport_introspection_c")
LIBRARIES = (
    "rosidl_runtime_c",
    "rosidl_typesupport_c",
    "rosidl_typesupport_fastrtps_c",
    "rosidl_typesupport_fastrtps_cpp",
    "rosidl_typesupport_introspection_c",
    "rcutils",
    "fastcdr",
)
PREFIX = Path(sys.prefix)
SITE = Path(sysconfig.get_path("purelib"))


def generate(folder: Path, package: str, share: Path) -> None:
    """Write the sources of a package, each generator's in a folder of its own: names of their files are the same."""
    source = folder / package
    files = [
        f"{source}:{path.relative_to(source)}"
        for sort in ("msg", "srv", "action")
        for path in sorted((source / sort).glob(f"*.{sort}"))
    ]
    # That of C looks for types by their names alone, and an action may have the name of a message.
    actions = [one for one in files if one.endswith(".action")]
    sets = [part for part in ([one for one in files if one not in actions], actions) if part]
    for module, name in GENERATORS.items():
        generator = getattr(importlib.import_module(f"{module}.cli"), name)(module)
        out = folder / module / package
        out.mkdir(parents=True)
        for part in sets if module == "rosidl_generator_c" else [files]:
            generator.generate(package, part, [str(share)], output_path=out)
            if module == "rosidl_generator_c":
                install_definitions(out, share / package)


def install_definitions(out: Path, target: Path) -> None:
    """Install what other types, and other packages, use."""
    shutil.copytree(out / "tmp", target, dirs_exist_ok=True)
    for path in out.glob("*/*.json"):
        shutil.copy(path, target / path.parent.name)


def flags(folder: Path) -> list[str]:
    """Those of all compilations."""
    places = [folder / module for module in GENERATORS]
    places += [PREFIX / "include", *(path for path in (PREFIX / "include").iterdir() if path.is_dir())]
    python = sysconfig.get_path("include")
    return ["-O1", "-fPIC", "-w", *(f"-I{place}" for place in [*places, python, numpy.get_include()])]


def run(command: list[str]) -> None:
    """Run a compiler.

    Raises:
        SystemExit: it fails.
    """
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f"{' '.join(command)[:300]}...\n{done.stderr[-3000:]}")


def compile_package(folder: Path, package: str) -> None:
    """Compile a package's sources, and install it."""
    common = flags(folder)
    outs = [folder / module / package for module in GENERATORS]
    sources = [path for out in outs for path in out.rglob("*.c*") if ".ep." not in path.name]
    objects = [str(path.with_name(f"{path.name}.o")) for path in sources]
    jobs = []
    for path, made in zip(sources, objects, strict=True):
        compiler = ["cc"] if path.suffix == ".c" else ["c++", "-std=c++17"]
        jobs.append([*compiler, *common, "-c", str(path), "-o", made])
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        list(pool.map(run, jobs))
    library = PREFIX / "lib" / f"lib{package}__libgz.so"
    found = [path.stem[3:] for path in (PREFIX / "lib").glob("lib*__rosidl_*.so") if not path.stem.endswith("_cpp")]
    needed = [f"-l{name}" for name in (*LIBRARIES, *sorted(found)) if not name.startswith(f"{package}__")]
    for support in ("rosidl_generator_c", "rosidl_generator_py", *SUPPORTS):
        (PREFIX / "lib" / f"lib{package}__{support}.so").unlink(missing_ok=True)
    link = [f"-L{PREFIX / 'lib'}", "-Wl,-rpath,$ORIGIN", "-Wl,--as-needed"]
    run(["c++", "-shared", "-o", str(library), *objects, *link, *needed])
    for support in ("rosidl_generator_c", "rosidl_generator_py", *SUPPORTS):
        (PREFIX / "lib" / f"lib{package}__{support}.so").symlink_to(library.name)
    own = folder / "rosidl_generator_py" / package
    target = SITE / package
    shutil.rmtree(target, ignore_errors=True)
    for path in own.glob("*/*.py"):
        (target / path.parent.name).mkdir(parents=True, exist_ok=True)
        shutil.copy(path, target / path.parent.name)
    (target / "__init__.py").touch()
    for support in SUPPORTS:
        module = target / f"{package}_s__{support}.so"
        given = [f"-L{PREFIX / 'lib'}", f"-Wl,-rpath,{PREFIX / 'lib'}", f"-l{package}__libgz", "-lrosidl_runtime_c"]
        run(["cc", "-shared", *common, "-o", str(module), str(own / f"_{package}_s.ep.{support}.c"), *given])


def main() -> None:
    """Build the packages, in the order in which they are named."""
    folder, packages = Path(sys.argv[1]), sys.argv[2:]
    os.environ["AMENT_PREFIX_PATH"] = str(PREFIX)
    index = PREFIX / "share" / "ament_index" / "resource_index" / "packages"
    for package in packages:
        generate(folder, package, PREFIX / "share")
        compile_package(folder, package)
        index.mkdir(parents=True, exist_ok=True)
        (index / package).touch()
        sys.stderr.write(f"built {package}\n")


if __name__ == "__main__":
    main()
