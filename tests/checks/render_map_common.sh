# What the checks of render_map share. Source it with the program's path in $1; it changes into a folder of its own, which goes
# with the script. A script ends with `finish`.
set -u
LC_ALL=C
export LC_ALL
case $1 in
/*) program=$1 ;;
*) program=$PWD/$1 ;;
esac
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
failures=0
address_space_kib= # `ulimit -v` of every run; empty: none

fail() {
    echo "FAILED: $*" | cut -c 1-600
    failures=$((failures + 1))
}
skip() { echo "skipped: $*"; }

# run ARGUMENTS...: the program's status; 124 where it hangs, 137 where it does not end at SIGTERM either.
run() (
    [ -z "$address_space_kib" ] || ulimit -v "$address_space_kib"
    exec timeout -k 5 120 "$program" "$@" </dev/null
)

# The line on standard error if pictures lack something.
missing_line='^[^ ].* lacks\{0,1\} .* ([0-9,]* [a-z_].*); .'

# runs ARGUMENTS...: status 0, and nothing on standard error except the line of what the pictures lack.
runs() {
    run "$@" >stdout 2>stderr || fail "status $? of: $*: $(cat stderr)"
    if grep -a -v "$missing_line" stderr >other_lines || [ "$(wc -l <stderr)" -gt 1 ]; then fail "standard error of: $*: $(cat stderr)"; fi
    rm -f other_lines
}

# is_refusal STATUS PATTERN: status 2 and, in the file stderr, exactly one line, "<problem> (<why>); <what to do>", that matches
# the pattern.
is_refusal() {
    [ "$1" -eq 2 ] || fail "status $1, not 2: $2: $(cat stderr)"
    [ "$(wc -l <stderr)" -eq 1 ] || fail "not one line: $2: $(cat stderr)"
    [ "$(wc -c <stderr)" -lt 1100 ] || fail "a very long line: $2: $(cat stderr)"
    grep -a -q '^[^(].* (.*); .' stderr || fail "not \"problem (why); what to do\": $(cat stderr)"
    grep -a -q -e "$2" stderr || fail "\"$2\" is not in: $(cat stderr)"
}

# refuses PATTERN ARGUMENTS...: nothing on standard output, and a refusal.
refuses() {
    pattern=$1
    shift
    run "$@" >stdout 2>stderr
    is_refusal $? "$pattern"
    [ ! -s stdout ] || fail "standard output of: $*"
}

same() { cmp -s "$1" "$2" || fail "$1 and $2 differ"; }
# sum FILE COLUMN: of a CSV without quotes, by the column's name.
sum() {
    awk -F, -v name="$2" 'NR == 1 { for (i = 1; i <= NF; ++i) if ($i == name) c = i; next }
        { s += $c } END { if (!c) print "no column " name; else printf "%.0f\n", s }' "$1"
}
# counter FILE KEY FRAME: the number of "KEY": in the run's report, of the frame from 0.
counter() { sed '/"losses": {/,/}/d' "$1" | grep -oE "\"$2\": [0-9]+" | sed -n "$(($3 + 1))s/.*: //p"; }
# equal WHAT A B
equal() { [ "$2" = "$3" ] || fail "$1: $2 is not $3"; }
# has FILE PATTERN
has() { grep -a -q -e "$2" "$1" || fail "\"$2\" is not in $1"; }

have_python() { command -v python3 >/dev/null && python3 -c '' 2>/dev/null; }
# is_json FILE: somebody else can parse it.
is_json() {
    if ! have_python; then
        skip "python3 is absent, so nobody else parses $1"
    elif ! python3 -m json.tool "$1" >/dev/null; then
        fail "$1 is no JSON"
    fi
}

# has_no_parts FOLDER
has_no_parts() { [ "$(find "$1" -name '*.part' | wc -l)" -eq 0 ] || fail "a .part file is left in $1"; }
# has_whole_pictures FOLDER: it holds some PNG, and each ends with its last chunk.
has_whole_pictures() {
    found=0
    for png in "$1"/*.png; do
        [ "$(tail -c 8 "$png" | od -An -tx1 | tr -d ' \n')" = 49454e44ae426082 ] || fail "$png is not whole"
        found=1
    done
    [ $found -eq 1 ] || fail "$1 has no picture"
}

finish() {
    [ $failures -eq 0 ] || { echo "$failures failures"; exit 1; }
    echo "$(basename "$program"): all good"
}
