#!/bin/sh
# Installs what the tests of C++ plugins, of 32-bit programs, of images by EGL and of written SDF need. What cannot be
# installed is said, and its tests are skipped, or fail.
set -eu

as_root=
if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null && sudo -n true 2>/dev/null && as_root="sudo -n" || as_root=none
fi
export DEBIAN_FRONTEND=noninteractive

has_cxx() { echo "#include <exception>" | ${CXX:-g++} -x c++ -fsyntax-only - 2>/dev/null; }
has_gl_header() { echo "#include <GL/gl.h>" | ${CXX:-g++} -x c++ -fsyntax-only - 2>/dev/null; }
has_egl() { python3 -c "import ctypes; ctypes.CDLL('libEGL_mesa.so.0'), ctypes.CDLL('libEGL.so.1')" 2>/dev/null; }
has_m32() { echo "int main(void) { return 0; }" | ${CC:-gcc} -m32 -x c - -o /dev/null 2>/dev/null; }

# install PACKAGES WHAT: what needs them
install() {
    log=$(mktemp)
    if [ "$as_root" != none ] && command -v apt-get >/dev/null; then
        echo "installing $1"
        # shellcheck disable=SC2086 # a list of words
        if { $as_root apt-get -q update && $as_root apt-get -q install -y --no-install-recommends $1; } >"$log" 2>&1
        then
            rm -f "$log"
            return
        fi
        tail -n 3 "$log" >&2
    fi
    rm -f "$log"
    echo "$1 could not be installed, which the tests of $2 need" >&2
}

has_cxx || install g++ "C++ plugins"
has_gl_header || install libgl-dev "C++ plugins that draw"
has_egl || install "libegl1 libegl-mesa0 libgl1-mesa-dri" "images by EGL"
has_m32 || install gcc-multilib "32-bit programs"
installed() { dpkg-query -W "$@" >/dev/null 2>&1; }
boost=$(printf "libboost-%s-dev " thread filesystem program-options regex iostreams date-time system)
classic="pkg-config cmake python3-dev libsdformat-dev libignition-math-dev libprotobuf-dev protobuf-compiler $boost"
# shellcheck disable=SC2086 # a list of words
installed $classic || install "$classic" "C++ plugins of Gazebo classic"
installed qtbase5-dev || install qtbase5-dev "GUI plugins of Gazebo classic"
command -v ign >/dev/null || install "ignition-tools libsdformat-dev" "SDF that sdformat reads"
