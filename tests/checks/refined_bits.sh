#!/bin/sh
# usage: refined_bits.sh COMPILER INCLUDE PROGRAM
# Builds refined_bits.cpp and wants the same map from all builds that have the same `multiply_add`: by COMPILER and by every other
# compiler that is there, whatever the optimisation. With TILEMESH_FAST=1 it makes one build by each of two compilers.
set -eu
compiler=$1 include=$2 program=$3
failed=0 built=0

build() { # COMPILER FLAGS...
    "$@" -std=c++20 -Wno-psabi -I "$include" refined_bits.cpp -o "$program" -pthread
    bits=$("$program")
    printf '%s:\n%s\n' "$*" "$bits"
    built=$((built + 1))
    if [ -n "$expected" ] && [ "$bits" != "$expected" ]; then
        echo "DIFFERENT from the build before"
        failed=1
    fi
    expected=$bits
}
others=
for other in g++ clang++-16 clang++; do
    command -v "$other" >/dev/null || continue
    [ "$("$other" --version | head -n 1)" = "$("$compiler" --version | head -n 1)" ] || others="$others $other"
done
[ -n "$others" ] || echo "note: there is no other compiler, so only flags are compared"

expected=
build "$compiler" -O2 -march=native
if [ -n "${TILEMESH_FAST:-}" ]; then
    for other in $others; do build "$other" -O1 -march=native && break; done
    exit $failed
fi
build "$compiler" -O0 -march=native
build "$compiler" -O3 -march=native -ffp-contract=fast
for other in $others; do build "$other" -O2 -march=native; done
expected=
build "$compiler" -O2 # no fused operation, and the widest set that this processor has
build "$compiler" -O2 -DTILEMESH_INSTRUCTION_SETS=0
for other in $others; do build "$other" -O2; done
echo "$built builds"
exit $failed
