#!/bin/sh
# usage: includes.sh PROJECT
# A file of examples, benches or tests includes what it uses. The umbrella tilemesh/tilemesh.hpp makes a unit compile for seconds longer,
# so only the files of includes.txt include it.
set -u
export LC_ALL=C
cd "$1" || exit 1
failed=0
grep -rlE '^ *# *include *<tilemesh/tilemesh\.hpp>' --include='*.cpp' --include='*.hpp' examples bench tests | sort >"${TMPDIR:-/tmp}/includes.$$"
trap 'rm -f "${TMPDIR:-/tmp}/includes.$$"' EXIT
while read -r file; do
    grep -qE "^$file( |\$)" tests/checks/includes.txt && continue
    echo "$file includes tilemesh/tilemesh.hpp (tests/checks/includes.txt does not name it); include the headers that it uses"
    failed=1
done <"${TMPDIR:-/tmp}/includes.$$"
while read -r file reason; do
    case $file in '' | '#'*) continue ;; esac
    [ -e "$file" ] || { echo "tests/checks/includes.txt names $file (there is no such file); remove the line" && failed=1; }
    [ -n "$reason" ] || { echo "tests/checks/includes.txt names $file (it gives no reason); add the reason" && failed=1; }
    grep -qx "$file" "${TMPDIR:-/tmp}/includes.$$" || echo "note: $file no longer includes tilemesh/tilemesh.hpp; remove its line from tests/checks/includes.txt"
done <tests/checks/includes.txt
exit $failed
