#!/bin/sh
# NGSolve's linear algebra needs Fortran's run-time library: Debian's libgfortran5, installed here if
# it can be.
set -eu
for folder in /lib /usr/lib /usr/local/lib; do
    find "$folder/" -maxdepth 2 -name 'libgfortran.so.5*' 2>/dev/null | grep -q . && exit 0
done
if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
    apt-get update -qq
    DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends libgfortran5 >/dev/null
else
    echo "make: links from CAD need libgfortran5; on Debian: apt-get install libgfortran5" >&2
    exit 1
fi
