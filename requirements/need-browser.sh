#!/bin/sh
# The tests look at the report in a real browser: Debian's chromium, installed here if it can be.
set -eu
command -v chromium >/dev/null && exit 0
if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
    apt-get update -qq
    DEBIAN_FRONTEND=noninteractive apt-get install -y -qq chromium >/dev/null
else
    echo "make: the tests need chromium; on Debian: apt-get install chromium" >&2
    exit 1
fi
