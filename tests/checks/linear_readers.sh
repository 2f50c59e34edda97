#!/bin/sh
# usage: linear_readers.sh COMPILER PROJECT FOLDER
# Every reader takes linear time: a file eight times as long takes at most ten times the steps. And it takes at most the memory that
# .github/SECURITY.md states. linear_readers.cpp defines a step. The check reads no clock, so its result is the same on every machine.
# The standard library's templates are compiled here too (_GLIBCXX_EXTERN_TEMPLATE), so that their steps count.
set -eu
export LC_ALL=C
compiler=$1 project=$2 folder=$3
source=$(dirname "$0")/linear_readers.cpp
command -v "$compiler" >/dev/null 2>&1 || { echo "skipped: the compiler is absent ($compiler)" && exit 0; }
mkdir -p "$folder"
"$compiler" -std=c++20 -O1 -w -DCOUNTER -c "$source" -o "$folder/counter.o"
"$compiler" -std=c++20 -O1 -w -D_GLIBCXX_EXTERN_TEMPLATE=0 -fno-builtin-memcpy -fsanitize-coverage=trace-pc -I "$project/include" -c "$source" -o "$folder/readers.o"
wraps=$(printf -- '-Wl,--wrap=%s ' memcpy memmove memset memchr memcmp)
# shellcheck disable=SC2086
"$compiler" "$folder/readers.o" "$folder/counter.o" $wraps -pthread -o "$folder/linear_readers"
"$folder/linear_readers"
