#!/bin/sh
# Checks the types of the page's modules, libgz/view/client, by TypeScript from their JSDoc comments. Installs Debian's npm
# where it is missing, and by it the versions below into .venv/client. Where that is not possible, this says so.
set -eu
cd "$(dirname "$0")/.."
folder=.venv/client
wanted="typescript@7.0.2 @types/three@0.185.4 uplot@1.6.32"

if ! command -v npm >/dev/null; then
    as_root=
    if [ "$(id -u)" -ne 0 ]; then
        command -v sudo >/dev/null && sudo -n true 2>/dev/null && as_root="sudo -n" || as_root=none
    fi
    export DEBIAN_FRONTEND=noninteractive
    log=$(mktemp)
    if [ "$as_root" = none ] || ! command -v apt-get >/dev/null ||
        ! { $as_root apt-get -q update && $as_root apt-get -q install -y --no-install-recommends nodejs npm; } >"$log" 2>&1
    then
        tail -n 3 "$log" >&2
        rm -f "$log"
        echo "npm could not be installed: the types of the page's modules are not checked" >&2
        exit 0
    fi
    rm -f "$log"
fi

if [ "$(cat "$folder/installed" 2>/dev/null || true)" != "$wanted" ]; then
    echo "installing TypeScript into $folder"
    rm -rf "$folder"
    mkdir -p "$folder"
    # shellcheck disable=SC2086 # a list of words
    npm install --silent --no-audit --no-fund --no-save --ignore-scripts --prefix "$folder" $wanted || {
        echo "TypeScript could not be installed: the types of the page's modules are not checked" >&2
        exit 0
    }
    echo "$wanted" >"$folder/installed"
fi
"$folder/node_modules/.bin/tsc" -p libgz/view/client/tsconfig.json
