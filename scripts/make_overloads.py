"""Writes the overloads of `World.interface`, so that type checkers and editors know the class of each interface.

python scripts/make_overloads.py
"""

from __future__ import annotations

import re
from pathlib import Path

from libgz.interfaces.catalog import INTERFACES

WORLD = Path(__file__).parent.parent / "libgz" / "simulation" / "world.py"
IMPORTS = re.compile(r"(?<=by scripts/make_overloads.py\n)(?:    .*\n)+")
OVERLOADS = re.compile(
    r"(?<=    # Written by scripts/make_overloads.py.\n).*?(?=    # End of what is written.\n)", re.S
)


def with_overloads(source: str) -> str:
    """The source of simulation/world.py with an overload for each interface of the catalogue."""
    kinds = [(type_, kind.__name__, kind.__module__) for type_, kind in sorted(INTERFACES.items())]
    # The module imports Sim at run time, too.
    imports = "".join(f"    from {module} import {name}\n" for type_, name, module in kinds if type_ != "sim")
    overloads = [(f'Literal["{type_}"]', name) for type_, name, _ in kinds] + [("str", "Interface[Any]")]
    text = "".join(
        f"    @overload\n    def interface(self, type: {type_}, id: str) -> {name}: ...\n\n"
        for type_, name in overloads
    )
    return OVERLOADS.sub(text, IMPORTS.sub(imports, source, count=1), count=1)


if __name__ == "__main__":
    WORLD.write_text(with_overloads(WORLD.read_text()))
