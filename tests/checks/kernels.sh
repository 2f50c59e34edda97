#!/bin/sh
# usage: kernels.sh COMPILER NM INCLUDE FOLDER_OF_kernel_headers.hpp OBJECT STANDARD
# Compiles kernels.cpp under the flags of a codelet build, and allows its object no symbols but libm, mem* and the contract handler,
# and no data that changes.
set -eu
export LC_ALL=C
compiler=$1 nm=$2 include=$3 headers=$4 object=$5 standard=$6

frames="-Wframe-larger-than=5120" # bytes of stack; compositing keeps a block of 1.3 KiB (1.9 with depth) or two cells of as much, 16 splats and row limits
if "$compiler" --version | grep -q 'Free Software Foundation'; then frames="$frames -Wstack-usage=5120"; fi
# shellcheck disable=SC2086
"$compiler" "-std=c++$standard" -O2 -fno-exceptions -fno-rtti -Wall -Wextra -Wconversion -Wshadow -Wdouble-promotion -Wvla \
    -pedantic $frames -Werror -I "$include" -I "$headers" -c kernels.cpp -o "$object"

allowed='(log|sqrt|floor|ceil|fma|fabs|round|trunc)f|mem(cpy|move|set|cmp)'
allowed="$allowed|tilemesh_contract_broken|_GLOBAL_OFFSET_TABLE_|__stack_chk_fail"
needed=$("$nm" -u "$object" | awk '{ print $NF }' | grep -vxE "$allowed" || true)
if [ -n "$needed" ]; then echo "kernel code needs:" && echo "$needed" && exit 1; fi
data=$("$nm" "$object" | grep -E ' [bBdDcCsS] ' || true)
if [ -n "$data" ]; then echo "kernel code has data that changes:" && echo "$data" && exit 1; fi
"$nm" -u "$object"
