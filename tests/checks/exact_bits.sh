#!/bin/sh
# usage: exact_bits.sh COMPILER INCLUDE FOLDER_OF_kernel_headers.hpp PROGRAM
# Builds bits.cpp by plain command lines and wants the same bits from all that have the same `multiply_add`: whatever the
# optimisation, and whether or not the user's flags let the compiler fuse a * b + c. With TILEMESH_FAST=1 it makes two builds of six.
set -eu
compiler=$1 include=$2 headers=$3 program=$4
failed=0

group() { # a name, then one string of flags a build
    name=$1 expected=
    shift
    for flags in "$@"; do
        # shellcheck disable=SC2086
        "$compiler" -std=c++20 $flags -I "$include" bits.cpp -o "$program" -pthread
        bits=$("$program") || failed=1
        printf '%s, %s:\n%s\n' "$name" "$flags" "$bits"
        if [ -n "$expected" ] && [ "$bits" != "$expected" ]; then
            echo "DIFFERENT from the build before"
            failed=1
        fi
        expected=$bits
    done
}

# Compilers fuse by default as much as they are allowed here, or less.
if [ -n "${TILEMESH_FAST:-}" ]; then
    group "this machine" "-O3 -march=native -ffp-contract=fast" "-O0 -march=native -ffp-contract=off"
    exit $failed
fi
group "this machine" "-O3 -march=native -ffp-contract=off" "-O3 -march=native -ffp-contract=fast" "-O0 -march=native"
group "any machine" "-O3" "-O0" "-O3 -DTILEMESH_INSTRUCTION_SETS=0" # the first two use the widest set that this processor has

# Clang marks what it may fuse: nothing in kernel code. (Its pictures alone would hardly show it.)
if "$compiler" --version | grep -q clang; then
    "$compiler" -std=c++20 -O0 -S -emit-llvm -gline-tables-only -I "$include" -I "$headers" kernels.cpp -o "$program.ll"
    if grep 'call .*llvm.fmuladd' "$program.ll"; then
        grep -B40 'call .*llvm.fmuladd' "$program.ll" | grep '^define' && echo "^ may be fused there" && failed=1
    fi
    rm -f "$program.ll"
fi
exit $failed
