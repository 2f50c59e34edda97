#!/bin/sh
# usage: second_step.sh PROJECT [FOLDER [CMAKE_ARGUMENT...]]
# What a second counter, size, word of a policy or option costs is a change of at most three files: second_step/*.patch. Without FOLDER, the check only sees that each
# patch there fits PROJECT and changes so few files. With FOLDER, it changes a copy of PROJECT there, builds the copy, and looks for the new
# thing in each place where a user meets it. Another step needs a NAME.patch, and a function see_NAME below.
set -eu
patches=$(cd "$(dirname "$0")" && pwd)/second_step
command -v patch >/dev/null || { echo "skipped: there is no program patch" && exit 0; }
project=$(cd "$1" && pwd)
fail() {
    echo "FAILED: $*" >&2
    exit 1
}
for change in "$patches"/*.patch; do
    files=$(grep -c '^+++ ' "$change")
    [ "$files" -le 3 ] || fail "$change changes $files files"
    patch --dry-run --fuzz=0 -s -p1 -d "$project" <"$change" || fail "$change does not fit"
    echo "$(basename "$change" .patch): $files files, $(grep -c '^+[^+]' "$change") lines"
done
[ $# -gt 1 ] || exit 0

folder=$2
shift 2
rm -rf "$folder" && mkdir -p "$folder/copy"
(cd "$project" && tar -c --exclude=./build --exclude=./.git .) | tar -x -C "$folder/copy"
for change in "$patches"/*.patch; do patch -s -p1 -d "$folder/copy" <"$change"; done
cd "$folder/copy"
build() { # TARGET...; the output only if it fails
    cmake --build build --target "$@" >build.log 2>&1 || { tail -n 50 build.log >&2 && fail "no $*"; }
}
cmake --preset ci -B build "$@" >build.log 2>&1 || { tail -n 20 build.log >&2 && fail "the copy cannot be configured"; }
build update_schema
build render_map tilemesh_c explore check_report_schema
./build/examples/render_map --size 320x200 --fit off --quiet --out out --report report.json --trace trace >/dev/null
./build/examples/render_map --size 320x200 --fit off --out out >text
./build/tests/checks/check_report_schema include/tilemesh/report/report.schema.json report.json >schema.log 2>&1 || true

# The C interface, for the Python programs below.
cat >chip.py <<'TEXT'
import ctypes, json
chip = ctypes.CDLL("build/examples/libtilemesh_c.so")
chip.tilemesh_create.restype = ctypes.c_void_p
chip.tilemesh_report.restype = ctypes.c_char_p
handle = ctypes.c_void_p(chip.tilemesh_create())
ask = lambda what: json.loads(chip.tilemesh_report(handle, what))
def render(): assert chip.tilemesh_render(handle, (ctypes.c_double * 17)(*ask(b"map")["start"]))
TEXT
# The messages of bloom are all messages without those of routing.
see_counter() {
    grep -q '"copies_sent": {"description": "Messages of bloom.", "type": "integer", "minimum": 0}' include/tilemesh/report/report.schema.json ||
        fail "the schema has no counter"
    ! grep 'report.json: ' schema.log || fail "the schema does not describe the report"
    grep -q '^exchanged: .* copies sent, ' text || fail "the text has no counter"
    head -n 1 trace/frames.csv | grep -q ',copies_sent,' || fail "the CSV has no counter"
    grep -q '>copies_sent<.*>Messages of bloom\.<' trace/report.html || fail "the page of a trace has no counter"
    cat >see.py <<'TEXT'
import csv, sys
sys.path[:0] = ["examples"]
import read_report
from chip import *
def check(what, copies, hops, messages):
    print(what, copies, hops, messages)
    assert copies > 1000 and copies == messages - hops
report = read_report.load_report("report.json")
check("report.json", *(read_report.column(report, name)[0] for name in ("copies_sent", "hops", "messages")))
row = next(csv.DictReader(open("trace/frames.csv")))
check("CSV", *(int(row[name]) for name in ("copies_sent", "hops", "messages")))
render()
frame = ask(b"run")["frames"][0]
check("C, from Python", frame["copies_sent"], frame["hops"], frame["messages"])
TEXT
    python3 see.py || fail "report.json, the CSV or C has another counter"
}
# see_field OPTION VALUE: a field that every program has. Its value is a word, or a number.
see_field() {
    name=$(printf %s "$1" | tr - _)
    case $2 in [0-9]*) json=$2 ;; *) json="\"$2\"" ;; esac
    ./build/examples/render_map --help | grep -q -e "^  --$1 " || fail "--help has no $1"
    ./build/examples/render_map --size 320x200 --quiet --out out --report field.json "--$1" "$2" >/dev/null
    grep -q "^  \"$name\": $json,$" field.json || fail "report.json has no $name of $json"
    grep -q "\"$name\": {\"description\": " include/tilemesh/report/report.schema.json || fail "the schema has no $name"
    printf '{"size": [160, 96], "machines": ["examples/machines/mk2.txt"], "policies": {"%s": [%s]}}\n' "$name" "$json" >study.json
    ./build/examples/explore study.json --csv points.csv --out points --quiet >/dev/null && grep -q '^mk2,' points.csv || fail "no study has $name"
    cat >see.py <<'TEXT'
import sys
from chip import *
name, value = sys.argv[1], json.loads(sys.argv[2])
assert ask(b"settings")[name] == "preset"
assert chip.tilemesh_set(handle, json.dumps({name: value, "width": 320, "height": 200}).encode())
assert str(ask(b"settings")[name]) == str(value)
render()
assert ask(b"run")["setup"][name] == value
TEXT
    python3 see.py "$name" "$json" || fail "C has no $name"
}
see_option() { see_field addressing recomputed; }
see_size() { see_field beam-slots 150; }
see_word() {
    ./build/examples/render_map --help | grep -q two_sigma_square || fail "--help has no word"
    ./build/examples/render_map --size 320x200 --quiet --out out --report field.json --footprint two_sigma_square >/dev/null
    [ "$(grep -c '"footprint": "two_sigma_square"' field.json)" -eq 2 ] || fail "report.json has no word"
    grep -q '"footprint": {.*"two_sigma_square"' include/tilemesh/report/report.schema.json || fail "the schema has no word"
}
for change in "$patches"/*.patch; do "see_$(basename "$change" .patch)"; done
