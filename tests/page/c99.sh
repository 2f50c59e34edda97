#!/bin/sh
# c99.sh CC LIBTILEMESH_C.so: the C interface is C99 without a warning, the example examples/c/first.c runs, and the library exports the
# functions of tilemesh.h and nothing else.
set -eu
cc=$1 library=$2
folder=$(dirname "$0")/../../examples/c
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
for standard in c99 c11; do
    "$cc" -std=$standard -pedantic-errors -Wall -Wextra -Wshadow -Wconversion -Wstrict-prototypes -Werror -I "$folder" "$folder/first.c" "$library" \
        -Wl,-rpath,"$(dirname "$library")" -lm -o "$work/first"
done
text=$("$work/first")
echo "$text"
case $text in
"320 x 180 pixels, the nearest at depth 1.03"*"tracked to 0.00000"*" units from its camera") ;;
*) echo "first printed another text"; exit 1 ;;
esac
status=0
"$work/first" "$work/absent.ply" >"$work/out" 2>"$work/err" || status=$?
test $status = 2
test ! -s "$work/out"
case $(cat "$work/err") in
"first: "*"absent.ply"*"("*"); "*) ;;
*) echo "that is not one line of the library:"; cat "$work/err"; exit 1 ;;
esac
test "$(wc -l <"$work/err")" = 1
sed -nE 's/^TILEMESH_C .*(tilemesh_[a-z_]+)\(.*/\1/p' "$folder/tilemesh.h" | sort >"$work/declared"
nm -D --defined-only "$library" | awk '{ print $3 }' | sort >"$work/exported"
diff "$work/declared" "$work/exported" || { echo "the library exports other symbols than tilemesh.h declares"; exit 1; }
test "$(wc -l <"$work/declared")" -ge 17
