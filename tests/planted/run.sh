#!/usr/bin/env bash
# usage: run.sh COMPILER [-j JOBS] [NN ...]    plants each fault (or those numbered) and wants the test files it names to fail
#        run.sh --apply                        only: every patch applies, and names test files that exist
#
# A fault is NN_name.patch: what a programmer might have done wrong, `# caught by: PART/FILE ...`, a diff of include/, examples/ or bench/.
# Where the build must fail: `# how: compile` and `# expect: TEXT OF THE STATIC_ASSERT`. Where a sanitizer may be the judge:
# `# flags: -fsanitize=address`, with which the tests are compiled and linked. `# check: codelets`, instead of a test file or besides:
# tests/checks/codelets.sh must refuse the fault. All of them must also pass without the fault.
# The real maps are not used. Scratch space: some 200 MB in TMPDIR.
set -u
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
limit_s=120 # a test file takes seconds: longer is a hang, and counts as caught

usage() {
    sed -n '2,3s/^# *//p' "$0" >&2
    exit 2
}
compiler=${1-}
jobs=1
[ -n "$compiler" ] || usage
shift
wanted=()
while [ $# -gt 0 ]; do
    case $1 in
    -j) jobs=${2-} && shift ;;
    -j*) jobs=${1#-j} ;;
    [0-9]*) wanted+=("$1") ;;
    *) usage ;;
    esac
    shift
done
[ "$jobs" -ge 1 ] 2>/dev/null || usage

work=$(mktemp -d "${TMPDIR:-/tmp}/tilemesh_planted.XXXXXX") || exit 2
trap 'rm -rf "$work"' EXIT
trap 'exit 130' INT TERM
export TILEMESH_FAST=1 TILEMESH_DATA=/nonexistent

field() { # NAME PATCH: the rest of the line "# NAME: ..."
    sed -n -e '/^---/q' -e "s/^# $1: *//p" "$2"
}

# Plants patch $2 in the copy of include/, examples/ and bench/ below $1; prints what is wrong and fails otherwise. Further arguments go to `patch`.
plant() {
    local log
    if ! log=$(patch -d "$1" -p1 -F2 -f -s --no-backup-if-mismatch "${@:3}" <"$2" 2>&1); then
        echo "FAIL: no longer applies ($(echo "$log" | tr '\n' ' '))"
        return 1
    fi
}

# Prints what is wrong with the head of patch $1.
check_head() {
    head -n 1 "$1" | grep -q '^# ..*[a-z]' || echo "FAIL: the first line does not say what is wrong"
    [ -n "$(field 'caught by' "$1")$(field check "$1")" ] || echo "FAIL: no line \"# caught by: part/file\", nor \"# check: codelets\""
    case $(field check "$1") in
    '' | codelets) ;;
    *) echo "FAIL: \"# check:\" is codelets, or absent" ;;
    esac
    for test in $(field 'caught by' "$1"); do
        [ -f "$root/tests/$test.cpp" ] || echo "FAIL: there is no tests/$test.cpp"
    done
    case $(field how "$1") in
    '') ;;
    compile) [ -n "$(field expect "$1")" ] || echo "FAIL: no line \"# expect: text of the static_assert\"" ;;
    *) echo "FAIL: \"# how:\" is compile, or absent" ;;
    esac
}

# Where headers are, of the tree $2 and for test file $1.
folders() {
    echo "-I$2/include"
    case $1 in
    poplar/*) echo "-I$2/examples -I$root/tests/poplar/standin" ;;
    model/* | report/*) echo "-I$2/bench" ;;
    esac
}
# Where test files are, of the tree $1: those of poplar/ include examples by relative paths, so a tree has its own.
tests_of() {
    if [ -d "$1/tests" ]; then echo "$1/tests"; else echo "$root/tests"; fi
}
# Builds test file $1 against the headers of $2 into $3, with what its part links beside it (sources without a test case); further
# arguments are flags.
build() {
    local beside tests
    tests=$(tests_of "$2")
    mapfile -t beside < <(grep -L TEST_CASE "$tests/${1%/*}"/*.cpp)
    # shellcheck disable=SC2046
    "$compiler" -std=c++20 -O1 -UNDEBUG -w "${@:4}" $(folders "$1" "$2") "$tests/$1.cpp" "${beside[@]}" "$work/main.o" -o "$3" -pthread
}
# Checks that test file $1 compiles, or not, against the headers of $2: static_asserts only.
only_compile() {
    # shellcheck disable=SC2046
    "$compiler" -std=c++20 -fsyntax-only -w $(folders "$1" "$2") "$(tests_of "$2")/$1.cpp"
}
# Runs tests/checks/$1.sh on the tree $2, with its output in $3.log.
check() {
    sh "$root/tests/checks/$1.sh" clang++-16 "$2" "$3" >"$3.log" 2>&1
}
# Runs program $1 with its output in $1.log.
run() {
    (cd "$(dirname "$1")" && timeout "$limit_s" "$1" -tce='slow:*' --no-colors=true >"$1.log" 2>&1; exit $?) 2>/dev/null
}
failed_cases() { # in the log $1
    sed -n 's/^\[doctest\] test cases:.*| *\([0-9]*\) failed.*/\1/p' "$1"
}
reported() { # by a sanitizer in the log $1: what
    sed -nE 's/.*(ERROR|WARNING): ((Address|Thread)Sanitizer: [A-Za-z -]*[A-Za-z]).*/\2/p; s/.*runtime error: (.*)/\1/p' "$1" | head -n 1
}

# The fault of this name: one line.
try_fault() {
    local name=$1 patch=$here/$1.patch dir=$work/$1 line="" test out status n wrong text flags
    mkdir "$dir" && cp -R "$root"/{include,examples,bench} "$dir" || return
    case " $(field 'caught by' "$patch")" in
    *' poplar/'*) mkdir "$dir/tests" && cp -R "$root"/tests/{engine,splat,poplar} "$dir/tests" || return ;;
    esac
    wrong=$(check_head "$patch")
    if [ -n "$wrong" ] || ! wrong=$(plant "$dir" "$patch"); then
        echo "${name/_/ }: $wrong"
        return
    fi
    read -ra flags < <(field flags "$patch")
    for test in $(field check "$patch"); do
        out=$dir/check_$test
        if check "$test" "$dir" "$out"; then
            line="FAIL: check.$test does not see it: $(tail -n 1 "$out.log")"
            if grep -q '^skipped: ' "$out.log"; then echo "${name/_/ }: check.$test is $(grep '^skipped: ' "$out.log")" && : >"$work/skipped_$name" && return; fi
        else
            line="$line, check.$test ($(head -n 1 "$out.log"))"
        fi
    done
    for test in $(field 'caught by' "$patch"); do
        case $line in FAIL*) break ;; esac
        out=$dir/${test//\//_}
        if [ "$(field how "$patch")" = compile ]; then
            text=$(field expect "$patch")
            if only_compile "$test" "$dir" >"$out.log" 2>&1; then
                line="FAIL: $test still compiles"
            elif ! grep -qF -- "$text" "$out.log"; then
                line="FAIL: $test fails to compile, but not with \"$text\": $(grep -m1 'error:' "$out.log")"
            else
                line="$line, $test (does not compile: \"$text\")"
            fi
        elif ! build "$test" "$dir" "$out" "${flags[@]}" >"$out.log" 2>&1; then
            line="FAIL: $test does not compile: $(grep -m1 'error:' "$out.log")"
        else
            run "$out"
            status=$?
            n=$(failed_cases "$out.log")
            if [ $status -eq 124 ]; then
                line="$line, $test (hangs)"
            elif [ $status -ne 0 ] && [ "${n:-0}" -gt 0 ]; then
                line="$line, $test ($n test cases failed$([ $status -lt 128 ] || echo ', the last by a crash'))"
            elif [ $status -ne 0 ] && [ ${#flags[@]} -gt 0 ] && [ -n "$(reported "$out.log")" ]; then
                line="$line, $test ($(reported "$out.log"))"
            else
                line="FAIL: $test does not see it (exit status $status: $(tail -n 1 "$out.log"))"
            fi
        fi
    done
    case $line in
    FAIL*) ;;
    *) line="caught by ${line#, }" && rm -rf "$dir" && : >"$work/caught_$name" ;;
    esac
    echo "${name/_/ }: $line"
}
# One test file without a fault: it must pass, or compile; or one check. $1: run, compile or check. Further arguments are flags.
try_control() {
    local out ok=0
    out=$(echo "control $*" | tr -c 'A-Za-z0-9\n' _)
    out=$work/$out
    if [ "$1" = compile ]; then
        only_compile "$2" "$root" >"$out.log" 2>&1 || ok=1
    elif [ "$1" = check ]; then
        check "$2" "$root" "$out" || ok=1
    else
        build "$2" "$root" "$out" "${@:3}" >"$out.log" 2>&1 && run "$out" || ok=1
        [ "$(failed_cases "$out.log")" = 0 ] && ! grep -q 'test cases: *0 ' "$out.log" || ok=1
    fi
    [ $ok -eq 0 ] && rm -rf "$out" && return
    grep -A 6 -e 'ERROR:' -e 'error:' "$out.log" | head -n 20
    tail -n 3 "$out.log"
    echo "control: tests/$([ "$1" = check ] && echo "checks/$2.sh" || echo "$2.cpp") fails without any fault${3+ (${*:3})}; put that right first"
    : >"$work/control_failed"
}

patches=()
for patch in "$here"/[0-9]*.patch; do
    number=$(basename "$patch")
    number=${number%%_*}
    case " ${wanted[*]-} " in
    "  " | *" $number "*) patches+=("$patch") ;;
    esac
done
[ ${#patches[@]} -gt 0 ] || usage

if [ "$compiler" = --apply ]; then
    bad=0
    for patch in "${patches[@]}"; do
        wrong=$(check_head "$patch")
        [ -n "$wrong" ] || wrong=$(plant "$root" "$patch" --dry-run) || bad=1
        [ -z "$wrong" ] || { echo "$(basename "$patch"): $wrong" && bad=1; }
    done
    double=$(basename -a "${patches[@]}" | sed 's/_.*//' | uniq -d)
    [ -z "$double" ] || { echo "FAIL: two patches with number $double" && bad=1; }
    echo "${#patches[@]} patches"
    [ ${#patches[@]} -ge 25 ] || bad=1
    exit $bad
fi

# Runs "$1 ARGUMENTS", the arguments read from stdin a line each, at most $jobs at a time.
in_parallel() {
    local arguments
    while read -r arguments; do
        while [ "$(jobs -rp | wc -l)" -ge "$jobs" ]; do wait -n; done
        # shellcheck disable=SC2086
        "$1" $arguments &
    done
    wait
}

SECONDS=0
"$compiler" -std=c++20 -O1 -w -c "$root/tests/main.cpp" -o "$work/main.o" || exit 2
for patch in "${patches[@]}"; do
    for test in $(field 'caught by' "$patch"); do
        [ ! -f "$root/tests/$test.cpp" ] || echo "$(field how "$patch" | grep . || echo run) $test $(field flags "$patch")"
    done
    for test in $(field check "$patch"); do echo "check $test"; done
done | sort -u >"$work/controls"
in_parallel try_control <"$work/controls"
[ ! -e "$work/control_failed" ] || exit 1
echo "control: $(wc -l <"$work/controls") test files and checks pass without a fault ($SECONDS s)"

basename -a -s .patch "${patches[@]}" | in_parallel try_fault
caught=$(find "$work" -name 'caught_*' | wc -l)
skipped=$(find "$work" -name 'skipped_*' | wc -l)
echo "$((caught)) of ${#patches[@]} caught$([ "$((skipped))" -eq 0 ] || echo ", $((skipped)) skipped") ($SECONDS s)"
[ $((caught + skipped)) -eq ${#patches[@]} ]
