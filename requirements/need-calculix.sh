#!/bin/sh
# The tests and `make bench-fea` solve parts with CalculiX: Debian's calculix-ccx, installed here if it can be.
set -eu
command -v ccx >/dev/null && exit 0
if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
    apt-get update -qq
    DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends calculix-ccx >/dev/null
else
    echo "make: CalculiX is needed; on Debian: apt-get install calculix-ccx" >&2
    exit 1
fi
