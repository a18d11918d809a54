#!/bin/sh
# Make the virtual environment $2 with the interpreter $1. A bare Debian ships Python without its
# venv module; as root we install the package that holds it, otherwise we say which one is missing.
set -eu
python=$1
venv=$2
version=$("$python" -c 'import sys; print("%d.%d" % sys.version_info[:2])') || {
    echo "make: no Python found as '$python'; install Python 3.11 or newer, or call 'make PYTHON=...'" >&2
    exit 1
}
"$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' || {
    echo "make: Python $version is too old, stiffkit needs 3.11 or newer; call 'make PYTHON=...'" >&2
    exit 1
}
if ! "$python" -c 'import venv, ensurepip' 2>/dev/null; then
    if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
        apt-get update -qq && apt-get install -y -qq "python$version-venv"
    else
        echo "make: Python $version has no venv module; on Debian: apt-get install python$version-venv" >&2
        exit 1
    fi
fi
"$python" -m venv --clear "$venv"
