#!/bin/sh
# usage: two_versions.sh COMPILER PROJECT FOLDER
# Two versions of the library in one program: this one, and a copy with another inline namespace and another text. Each unit must
# get the functions of its own version and report the broken contract of its own kernel.
set -eu
compiler=$1 include=$2/include folder=$3
here=$(cd "$(dirname "$0")" && pwd)
rm -rf "$folder" && mkdir -p "$folder" && cp -r "$include" "$folder/other"
find "$folder/other" -name '*.hpp' -exec sed -i -E 's/inline namespace v[0-9]+_[0-9]+/inline namespace v9_9/' {} +
sed -i 's/"push into a full channel/"PUSH into a full channel/' "$folder/other/tilemesh/machine/channel.hpp"
"$compiler" -std=c++20 -O0 -I "$include" -c "$here/two_versions.cpp" -o "$folder/this.o"
"$compiler" -std=c++20 -O0 -I "$folder/other" -DOTHER -c "$here/two_versions.cpp" -o "$folder/other.o"
"$compiler" "$folder/this.o" "$folder/other.o" -pthread -o "$folder/two_versions"
"$folder/two_versions"
