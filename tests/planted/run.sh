#!/usr/bin/env bash
# usage: run.sh [-c COMPILER] [-j JOBS] [-d DONE] [NN | NN-MM | PART/TEST | FILE]...
#                   plants each fault of faults.txt (or those numbered, or those that this test catches, or that change this file):
#                   every test that a fault names must fail. Default: Clang, which compiles fastest; else $CXX or c++. All cores.
#                   The file DONE lists the faults that were caught: a run that was stopped goes on. A fault is planted again if
#                   its text, the files that it changes or its tests have changed since, but not if another header has.
#        run.sh --check    only: the text of every fault is in its file, once, and the tests that it names exist
#        run.sh --move     rewrites faults.txt: a text that is in another file now names that file
#
# A test is compiled alone, without optimisation, against a copy of the project that holds the fault, and runs up to its first failure.
# First every test in question must pass without a fault. The real maps are not used. Scratch space: some 300 MB in TMPDIR.
# Tests of mpi/ need Open MPI and run on three ranks.
set -u
export LC_ALL=C
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
table() { # MODE [-v NAME=VALUE ...]
    awk -f "$here/faults.awk" -v mode="$1" -v root="$root" "${@:2}" "$here/faults.txt"
}
usage() {
    sed -n '2,8s/^# //p' "$0" >&2
    exit 2
}

case ${1-} in
--check)
    table check
    exit
    ;;
--move)
    if ! table move >"$here/faults.new"; then rm "$here/faults.new" && exit 1; fi
    mv "$here/faults.new" "$here/faults.txt"
    table check
    exit
    ;;
esac

compiler=
jobs=$(getconf _NPROCESSORS_ONLN 2>/dev/null || echo 2)
done_file=
wanted=()
while [ $# -gt 0 ]; do
    case $1 in
    -c) compiler=${2-} && shift ;;
    -j) jobs=${2-} && shift ;;
    -j*) jobs=${1#-j} ;;
    -d) done_file=${2-} && shift && [ -n "$done_file" ] || usage ;;
    -*) usage ;;
    *) wanted+=("$1") ;;
    esac
    shift
done
[ "$jobs" -ge 1 ] 2>/dev/null || usage
if [ -z "$compiler" ]; then
    for compiler in clang++-16 clang++ ${CXX-} c++; do
        if command -v "$compiler" >/dev/null; then break; fi
    done
fi
command -v "$compiler" >/dev/null || { echo "run.sh: there is no compiler $compiler (it is not in PATH); name one with -c" >&2 && exit 2; }

work=$(mktemp -d "${TMPDIR:-/tmp}/tilemesh_planted.XXXXXX") || exit 2
trap 'rm -rf "$work"' EXIT
trap 'kill $(jobs -p) 2>/dev/null; wait; exit 130' INT TERM
export TILEMESH_FAST=1 TILEMESH_DATA=/nonexistent
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1
export OMPI_MCA_mpi_yield_when_idle=1 OMPI_MCA_hwloc_base_binding_policy=none
mpi_flags=$(mpicxx.openmpi --showme:compile 2>/dev/null) && mpi_flags="-DOMPI_SKIP_MPICXX $mpi_flags" || mpi_flags=
mpi_libraries=$(mpicxx.openmpi --showme:link 2>/dev/null)

# ---- which faults
is_wanted() { # NUMBER TESTS FILES
    local one
    [ ${#wanted[@]} -gt 0 ] || return 0
    for one in "${wanted[@]}"; do
        case $one in
        */*) case " $2 $3 " in *" $one "*) return 0 ;; esac ;;
        *-*) [ "$1" -ge "${one%-*}" ] && [ "$1" -le "${one#*-}" ] && return 0 ;;
        *) [ "$1" -eq "$one" ] && return 0 ;;
        esac
    done
    return 1
}
for one in ${wanted[@]+"${wanted[@]}"}; do
    [[ $one == */* || $one =~ ^[0-9]+(-[0-9]+)?$ ]] || usage
done
# The fault as it is now: its number and a sum of its text, the files that it changes, and its tests.
key_of() { # NUMBER TESTS FILES
    local one
    {
        awk -v n="$1" '/^== / { on = $2 == n } on' "$here/faults.txt"
        for one in $2; do
            if [[ $one == checks/* ]]; then cat "$root/tests/$one.sh"; else cat "$root/tests/$one.cpp"; fi
        done
        for one in $3; do cat "$root/$one"; done
    } | cksum | sed "s/^/$1 /"
}
if [ -n "$done_file" ] && ! : >>"$done_file"; then
    echo "run.sh: $done_file cannot be written (option -d); name another file" >&2 && exit 2
fi
table list >"$work/all" || exit 1
before=0
while IFS='|' read -r number name tests flags refusal files; do
    if ! is_wanted "$number" "$tests" "$files"; then continue; fi
    if [ -n "$done_file" ] && grep -qxF "$(key_of "$number" "$tests" "$files")" "$done_file"; then
        before=$((before + 1))
    else
        echo "$number|$name|$tests|$flags|$refusal|$files" >>"$work/faults"
    fi
done <"$work/all"
if [ ! -e "$work/faults" ] && [ $before -gt 0 ]; then
    echo "$before of $before caught before, by $done_file" && exit 0
fi
[ -e "$work/faults" ] || { echo "run.sh: no fault is ${wanted[*]}; faults.txt lists them" >&2 && exit 2; }
total=$(wc -l <"$work/faults")
[ -z "$done_file" ] || echo "$before faults were caught before, by $done_file; $total are left"

# ---- trees: each job has a copy of the project of its own; `pristine` holds the files as they were
mkdir "$work/pristine"
cp -R "$root"/include "$root"/examples "$root"/bench "$root"/tests "$root"/machines "$root"/.github "$root"/.ci "$work/pristine" &&
    find "$root" -maxdepth 1 -type f -exec cp {} "$work/pristine" \; || exit 2
for ((job = 1; job <= jobs; ++job)); do cp -R "$work/pristine" "$work/tree_$job" || exit 2; done

# ---- kits: what all tests have in common, for each set of flags: a compiler, doctest's main, precompiled headers of others
cat >"$work/common.hpp" <<'headers'
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <map>
#include <memory>
#include <mutex>
#include <numeric>
#include <optional>
#include <random>
#include <span>
#include <sstream>
#include <string>
#include <thread>
#include <tuple>
#include <vector>
#include <doctest/doctest.h>
headers
kit_of() { # FLAGS
    echo "$work/kit_${1//[^a-z0-9]/_}"
}
make_kit() { # FLAGS
    local kit candidate
    kit=$(kit_of "$1")
    mkdir "$kit" && cp "$work/common.hpp" "$kit/common.hpp" && echo 'int main() {}' >"$kit/empty.cpp"
    for candidate in "$compiler" ${CXX-} c++ g++; do # a sanitizer's library need not be there for each
        # shellcheck disable=SC2086
        "$candidate" -pthread $1 "$kit/empty.cpp" -o "$kit/empty" 2>/dev/null && echo "$candidate" >"$kit/compiler" && break
    done
    [ -e "$kit/compiler" ] || return 0
    # shellcheck disable=SC2086
    "$candidate" -std=c++20 -O0 -pthread -UNDEBUG -w $1 -x c++-header "$kit/common.hpp" -o "$kit/common.hpp.gch" &&
        "$candidate" -std=c++20 -O0 -pthread -UNDEBUG -w $1 -c "$root/tests/main.cpp" -o "$kit/main.o"
}

# ---- one test
# The renderers of splat/runner.hpp are compiled apart for the suite (splat/shared). Here a file has the definition of those templates in
# front of it, and so contains the few renderers that it makes.
compile() { # TEST-FILE TREE FLAGS ARGUMENTS...
    local kit front=()
    kit=$(kit_of "$3")
    # shellcheck disable=SC2206
    if [[ $1 == mpi/* ]]; then front=($mpi_flags); fi
    if grep -qE '(make_runner|fit_shared)<' "$2/tests/$1.cpp"; then front+=(-include "$2/tests/splat/shared/runner_of.hpp"); fi
    # shellcheck disable=SC2086
    "$(cat "$kit/compiler")" -std=c++20 -O0 -pthread -UNDEBUG -w $3 -include "$kit/common.hpp" ${front[@]+"${front[@]}"} -I"$2/include" \
        -I"$2/bench" -I"$2/examples" -I"$2/tests/poplar/standin" "$2/tests/$1.cpp" "${@:4}"
}
# Builds a test into OUT, with what its part links beside it (sources without a test case). Objects that CHANGED files are no part of
# are those of the test without a fault.
build() { # TEST TREE FLAGS OUT CHANGED...
    local test=$1 tree=$2 flags=$3 out=$4 kit source object own objects=() file ends
    shift 4
    kit=$(kit_of "$flags")
    ends=("$kit/main.o")
    # shellcheck disable=SC2206
    if [[ $test == mpi/* ]]; then ends=($mpi_libraries); fi # their main is one of their sources
    while read -r source; do
        source=${test%/*}/$(basename "$source" .cpp)
        object=$kit/${source//\//_}.o
        own=$out.${#objects[@]}.o
        if [ -e "$object.d" ]; then
            for file in "$@"; do
                if grep -qF "/$file" "$object.d"; then object=$own && break; fi
            done
        fi
        if [ ! -e "$object" ]; then
            compile "$source" "$tree" "$flags" -MMD -MF "$own.d" -c -o "$own" || return
            if [ "$object" != "$own" ]; then mv "$own.d" "$object.d" && mv "$own" "$object"; fi
        fi
        objects+=("$object")
    done < <(grep -L TEST_CASE "$tree/tests/${test%/*}"/*.cpp)
    compile "$test" "$tree" "$flags" ${objects[@]+"${objects[@]}"} "${ends[@]}" -o "$out"
}
run() { # TEST PROGRAM SECONDS
    local front=()
    if [[ $1 == mpi/* ]]; then front=(mpirun.openmpi -n 3); fi
    shift
    (cd "$(dirname "$1")" && timeout -k 5 "$2" ${front[@]+"${front[@]}"} "$1" -aa=1 -tce='slow:*' --no-colors=true </dev/null >"$1.log" 2>&1; exit $?) 2>/dev/null
}
failed_cases() { # LOG: of the rank that has most
    sed -n 's/^\[doctest\] test cases:.*| *\([0-9]*\) failed.*/\1/p' "$1" | sort -n | tail -n 1
}
first_failed() { # LOG: the name of the test case (a message prints its name too)
    awk '/^TEST CASE: / { sub(/^TEST CASE: */, ""); name = $0 } /: (FATAL )?ERROR: / { print name; exit }' "$1"
}
reported() { # LOG: what a sanitizer says
    sed -nE 's/.*(ERROR|WARNING): ((Address|Thread)Sanitizer: [A-Za-z -]*[A-Za-z]).*/\2/p; s/.*runtime error: (.*)/\1/p' "$1" | head -n 1
}
check() { # NAME TREE OUT
    mkdir -p "$3"
    sh "$root/tests/checks/$1.sh" clang++-16 "$2" "$3" >"$3.log" 2>&1
}
now() {
    date +%s%3N
}

# ---- without a fault
# What a control is called: the test, its flags, and whether it is only compiled. A check has neither.
control_name() { # TEST FLAGS REFUSAL
    local name="$1_$2_${3:+compile}"
    [[ $1 != checks/* ]] || name=$1
    echo "${name//[^A-Za-z0-9]/_}"
}
try_control() { # JOB TEST|FLAGS|REFUSAL
    local tree=$work/tree_$1 test flags refusal name out ok=0 begin built
    IFS='|' read -r test flags refusal <<<"$2"
    name=$(control_name "$test" "$flags" "$refusal")
    out=$work/control_$name
    begin=$(now)
    built=$begin
    if [[ $test == checks/* ]]; then
        check "${test#*/}" "$tree" "$out" || ok=1
    elif [ ! -e "$(kit_of "$flags")/compiler" ]; then
        echo "skipped: no compiler here links $flags" >"$out.log"
    elif [[ $test == mpi/* && -z $mpi_flags ]]; then
        echo "skipped: Open MPI is not here (libopenmpi-dev, openmpi-bin)" >"$out.log"
    elif [ -n "$refusal" ]; then
        compile "$test" "$tree" "$flags" -fsyntax-only >"$out.log" 2>&1 || ok=1
    else
        build "$test" "$tree" "$flags" "$out" >"$out.log" 2>&1 && built=$(now) && run "$test" "$out" 600 || ok=1
        [ "$(failed_cases "$out.log")" = 0 ] && ! grep -q 'test cases: *0 ' "$out.log" || ok=1
    fi
    echo "$(($(now) - begin)) $(($(now) - built))" >"$work/ms_$name"
    if grep -m 1 '^skipped: ' "$out.log" >"$work/why_$name"; then return; fi
    rm -rf "$work/why_$name"
    if [ $ok -eq 0 ]; then rm -rf "$out" "$out".*.o "$out".*.d "$out.log" && return; fi
    grep -A 6 -e 'ERROR:' -e 'error:' "$out.log" | head -n 20
    tail -n 3 "$out.log"
    echo "control: tests/$test fails without any fault${flags:+ ($flags)}; correct that first"
    : >"$work/control_failed"
}

# ---- with a fault
# Says how a test takes the fault: "TEST (why it is caught)", or "NOT CAUGHT: ..." or "skipped: ...".
try_test() { # TEST TREE FLAGS REFUSAL OUT FILES...
    local test=$1 tree=$2 flags=$3 refusal=$4 out=$5 name status n ms
    name=$(control_name "$test" "$flags" "$refusal")
    if [ -e "$work/why_$name" ]; then
        cat "$work/why_$name"
    elif [[ $test == checks/* ]]; then
        if check "${test#*/}" "$tree" "$out"; then
            echo "NOT CAUGHT: $test passes: $(tail -n 1 "$out.log")"
        else
            echo "$test ($(head -n 1 "$out.log"))"
        fi
    elif [ -n "$refusal" ]; then
        if compile "$test" "$tree" "$flags" -fsyntax-only >"$out.log" 2>&1; then
            echo "NOT CAUGHT: $test still compiles"
        elif ! grep -qF -- "$refusal" "$out.log"; then
            echo "NOT CAUGHT: $test does not compile, but not because of \"$refusal\": $(grep -m 1 'error:' "$out.log")"
        else
            echo "$test (does not compile: \"$refusal\")"
        fi
    elif ! build "$test" "$tree" "$flags" "$out" "${@:6}" >"$out.log" 2>&1; then
        echo "NOT CAUGHT: $test does not compile: $(grep -m 1 'error:' "$out.log")"
    else
        read -r _ ms <"$work/ms_$name"
        run "$test" "$out" $((20 + ms / 100)) # ten times as long as without the fault is a hang, which counts as caught
        status=$?
        n=$(failed_cases "$out.log")
        if [ $status -eq 124 ]; then
            echo "$test (hangs)"
        elif [ $status -ne 0 ] && [ "${n:-0}" -gt 0 ]; then
            echo "$test (\"$(first_failed "$out.log")\"$([ $status -lt 128 ] || echo ' crashes'))"
        elif [ $status -ne 0 ] && [[ $test == mpi/* ]] && grep -q '^rank [0-9]* leaves' "$out.log"; then
            echo "$test ($(grep -m 1 '^rank [0-9]* leaves' "$out.log"))"
        elif [ $status -ne 0 ] && [ -z "$n" ] && [[ $test == mpi/* ]]; then
            echo "$test (MPI ends the job, status $status)"
        elif [ $status -ne 0 ] && [ -n "$flags" ] && [ -n "$(reported "$out.log")" ]; then
            echo "$test ($(reported "$out.log"))"
        elif [ $status -eq 134 ] || [ $status -eq 139 ]; then # aborted, or a bad address. There is no summary if two threads die at once
            echo "$test (crashes, status $status)"
        else
            echo "NOT CAUGHT: $test passes (exit status $status: $(tail -n 1 "$out.log"))"
        fi
    fi
}
try_fault() { # JOB NUMBER|NAME|TESTS|FLAGS|REFUSAL|FILES: prints one line
    local tree=$work/tree_$1 number name tests flags refusal files test says line="" begin out
    IFS='|' read -r number name tests flags refusal files <<<"$2"
    begin=$(now)
    out=$work/out_$1
    if ! says=$(table plant -v fault="$number" -v out="$tree" 2>&1 >/dev/null); then
        line="NOT CAUGHT: $(echo "$says" | head -n 1)"
        tests=
    fi
    for test in $tests; do
        # shellcheck disable=SC2086
        says=$(try_test "$test" "$tree" "$flags" "$refusal" "$out" $files)
        case $says in
        'NOT CAUGHT: '* | 'skipped: '*) line=$says && break ;;
        *) line="${line:-caught by }${line:+, }$says" ;;
        esac
        rm -rf "$out" "$out".*.o "$out".*.d "$out.log"
    done
    for file in $files; do cp "$work/pristine/$file" "$tree/$file"; done
    case $line in
    caught*)
        : >"$work/caught_$number"
        if [ -n "$done_file" ]; then key_of "$number" "$tests" "$files" >>"$done_file"; fi
        ;;
    skipped*) : >"$work/skipped_$number" ;;
    esac
    echo "$number $name: $line in $((($(now) - begin + 500) / 1000)) s"
}

# ---- all of them
# Calls "$1 JOB LINE" for every line of file $2; whoever is free takes the next.
in_parallel() {
    local job line
    for ((job = 1; job <= jobs; ++job)); do
        (
            n=0
            while read -r line; do
                n=$((n + 1))
                if mkdir "$2.claim_$n" 2>/dev/null; then "$1" "$job" "$line"; fi
            done <"$2"
        ) &
    done
    wait
}

SECONDS=0
while IFS='|' read -r _ _ tests flags refusal _; do
    for test in $tests; do
        if [[ $test == checks/* ]]; then echo "$test||"; else echo "$test|$flags|${refusal:+compile}"; fi
    done
done <"$work/faults" | sort -u >"$work/controls"
make_kit "" || exit 2
cut -d '|' -f 2 "$work/controls" | sort -u | while read -r flags; do
    if [ -n "$flags" ]; then make_kit "$flags" || exit 2; fi
done
in_parallel try_control "$work/controls"
[ ! -e "$work/control_failed" ] || exit 1
controls=$(wc -l <"$work/controls")

# What takes longest begins first, so that no job waits for another at the end.
sum_ms=0
while IFS= read -r fault; do
    IFS='|' read -r _ _ tests flags refusal _ <<<"$fault"
    ms=0
    for test in $tests; do
        read -r one _ <"$work/ms_$(control_name "$test" "$flags" "$refusal")"
        ms=$((ms + one))
    done
    sum_ms=$((sum_ms + ms))
    echo "$ms $fault"
done <"$work/faults" >"$work/timed"
echo "control: $controls tests pass without a fault ($SECONDS s); the faults will take about $((sum_ms / jobs / 1000)) s"
sort -rn "$work/timed" | cut -d ' ' -f 2- >"$work/queue"
in_parallel try_fault "$work/queue"

caught=$(find "$work" -maxdepth 1 -name 'caught_*' | wc -l)
skipped=$(find "$work" -maxdepth 1 -name 'skipped_*' | wc -l)
echo "$((caught)) of $((total)) caught$([ "$skipped" -eq 0 ] || echo ", $((skipped)) skipped") ($SECONDS s)"
[ $((caught + skipped)) -eq "$total" ]
