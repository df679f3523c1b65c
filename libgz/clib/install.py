"""Install: the header, the library and its pkg-config file where the build systems of old programs look for them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from libgz.base.errors import LibraryError
from libgz.base.files import write_whole
from libgz.clib import FOLDER
from libgz.clib.header import version_macro
from libgz.clib.library import ARCHIVE, FOR_I386, SHARED, library_folder
from libgz.clib.prefixes import note_prefix
from libgz.transport.layout import LIBGAZEBO_VERSION

__all__ = ["install"]

RELEASES = {0x050: "0.5.0", 0x060: "0.7.0"}  # of Gazebo, by version of the structs
LINK = "libgazebo.so"
PKG_CONFIG = """\
prefix={prefix}
exec_prefix=${{prefix}}
libdir=${{exec_prefix}}/lib
includedir=${{prefix}}/include

Name: gazebo
Description: Interfaces of the Gazebo robot simulator, of libgz
Version: {release}
Requires:
Libs: {i386}-L${{libdir}} -Wl,-rpath,${{libdir}} -lgazebo
Libs.private: -lm
Cflags: {i386}{flags}
"""


def install(
    prefix: Path,
    version: int = LIBGAZEBO_VERSION,
    headers: Mapping[str, bytes] | None = None,
    flags: str = "-I${includedir}",
    *,
    i386: bool = False,
) -> list[Path]:
    """Write gazebo.h, libgazebo.a, libgazebo.so.0 with its link, and gazebo.pc below a directory; returns their paths.

    The directory is remembered: plugins that worldfiles name are searched for below it, too.

    Args:
        prefix: such as `/usr/local`; missing directories are created.
        version: of the structs, one of `libgz.transport.layout.VERSIONS`.
        headers: further files, by their paths below the directory.
        flags: of the compiler, for gazebo.pc.
        i386: for 32-bit programs.

    Raises:
        LibraryError: the library cannot be compiled, or the directory cannot be written.
    """
    compiled = library_folder(version, i386=i386)
    prefix = prefix.expanduser().absolute()
    header = (FOLDER / "gazebo.h").read_text().replace(version_macro(LIBGAZEBO_VERSION), version_macro(version))
    description = PKG_CONFIG.format(
        prefix=str(prefix).replace(" ", "\\ "),
        release=RELEASES[version],
        flags=flags,
        i386=f"{FOR_I386} " if i386 else "",
    )
    contents = {
        prefix / "include" / "gazebo.h": header.encode(),
        prefix / "lib" / ARCHIVE: (compiled / ARCHIVE).read_bytes(),
        prefix / "lib" / SHARED: (compiled / SHARED).read_bytes(),
        prefix / "lib" / "pkgconfig" / "gazebo.pc": description.encode(),
        **{prefix / path: content for path, content in (headers or {}).items()},
    }
    link = prefix / "lib" / LINK
    try:
        for path, content in contents.items():
            path.parent.mkdir(parents=True, exist_ok=True)
            write_whole(path, content)
        link.unlink(missing_ok=True)
        link.symlink_to(SHARED)
    except OSError as error:
        raise LibraryError(f"the C library cannot be installed in {prefix}: {error.strerror}") from None
    note_prefix(prefix)
    return sorted([*contents, link])
