#!/bin/sh
# Make the environment $2, with the interpreter $1, that has the programs benchmarks/peers compares
# with. They are no dependencies of stiffkit and stay out of its own environment.
set -eu
here=$(dirname "$0")
"$here/make-venv.sh" "$1" "$2"
"$2/bin/python" -m pip install --quiet --disable-pip-version-check -r "$here/peers.txt"
