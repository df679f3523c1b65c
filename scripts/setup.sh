#!/bin/sh
# setup.sh EXTRA: Debian packages, a virtual environment, and this package in it with one of its extras: `view` suffices for
# `make demo`, `dev`, which contains it, is for tests. Nothing is installed that is there already.
# Needs python3, and root or sudo if Debian packages are missing; otherwise it prints which ones to install.
set -eu
cd "$(dirname "$0")/.."
extra=${1:?"usage: setup.sh view or setup.sh dev"}

has_library() { python3 -c "import ctypes, sys; ctypes.CDLL(sys.argv[1])" "$1" 2>/dev/null; }
has_venv() { python3 -c "import venv, ensurepip" 2>/dev/null; }
has_compiler() { echo "#include <stdlib.h>" | ${CC:-gcc} -x c -fsyntax-only - 2>/dev/null; }

command -v python3 >/dev/null || { echo "libgz needs python3: install Debian's package python3." >&2; exit 1; }

missing=
has_library libode.so.8 || missing="$missing libode8"
has_library libOSMesa.so.8 || missing="$missing libosmesa6"
has_venv || missing="$missing python3-venv"
has_compiler || missing="$missing gcc libc6-dev"

if [ -n "$missing" ]; then
    as_root=
    if [ "$(id -u)" -ne 0 ]; then
        command -v sudo >/dev/null && sudo -n true 2>/dev/null && as_root="sudo -n" || as_root=none
    fi
    if [ "$as_root" = none ] || ! command -v apt-get >/dev/null; then
        echo "libgz needs these packages of Debian 12, and this user cannot install them:$missing;" \
            "as root, run: apt-get install$missing" >&2
        exit 1
    fi
    echo "installing$missing"
    export DEBIAN_FRONTEND=noninteractive
    log=$(mktemp)
    # shellcheck disable=SC2086 # lists of words
    if ! { $as_root apt-get -q update && $as_root apt-get -q install -y --no-install-recommends $missing; } >"$log" 2>&1
    then
        tail -n 5 "$log" >&2
        echo "libgz needs these packages of Debian 12, and apt-get could not install them:$missing" >&2
        exit 1
    fi
    rm -f "$log"
fi

.venv/bin/python -c "import pip" 2>/dev/null || python3 -m venv --clear .venv

# Reinstall when a file of the package was added or removed, a build input changed, a compiler came, or build/ was removed:
# the installed tree is there, and links to this one. What the installation itself makes (.so, bytecode) does not count.
package_files() { find libgz interfaces models worlds -type f ! -name '*.so' ! -name '*.pyc' | LC_ALL=C sort; }
build_inputs() { echo setup.py setup.cfg pyproject.toml; package_files | grep '\.[ch]$'; }
# shellcheck disable=SC2046 # a list of words
inputs=$({ package_files; cat $(build_inputs); if has_compiler; then echo compiler; fi; } | cksum)
installed=$(cat .venv/installed 2>/dev/null || true)
if [ "${installed##* }" = dev ]; then extra=dev; fi # what was set up for tests stays so
if [ ! -d build ] || [ "$installed" != "$inputs $extra" ]; then
    echo "installing the package into .venv"
    rm -rf build .venv/installed
    .venv/bin/pip install --quiet --disable-pip-version-check --editable ".[$extra]" --config-settings editable_mode=strict
    echo "$inputs $extra" >.venv/installed
fi
# Compiled here, since where Python may not write its bytecode each command would compile the whole package anew.
.venv/bin/python -m compileall -q build
