#!/bin/sh
# usage: sources.sh PROJECT
# Reads the headers as text: who may include whom, and what kernel code (machine/, splat/, config.hpp, and what becomes codelets:
# `codelet_code` of poplar/, and in examples/ the heat equation and the codelet file) may say. Comments and string
# literals do not count.
set -eu
export LC_ALL=C
# shellcheck source-path=SCRIPTDIR source=kernel_headers.sh
. "$(dirname "$0")/kernel_headers.sh"
cd "$1/include/tilemesh"
failed=0
refuse() { # a reason, then what was found (nothing: all is well)
    if [ -n "$2" ]; then printf '%s:\n%s\n' "$1" "$2" && failed=1; fi
}
all=$(find . -name '*.hpp' | sed 's,^\./,,' | sort)
kernel_code=$(ls config.hpp machine/*.hpp splat/*.hpp splat/homes/*.hpp splat/map/*.hpp splat/pose/*.hpp)
codelet_code='poplar/(codelet|control_vertices|program_log|vertex_edges)\.hpp'
codelets="$(printf '%s\n' $all | grep -xE "$codelet_code") ../../examples/heat/heat.hpp ../../examples/on_poplar/codelets.cpp"

# "file: included" for every direct include.
# shellcheck disable=SC2086
includes=$(grep -HE '^ *# *include' $all ../../examples/heat/heat.hpp ../../examples/on_poplar/codelets.cpp | sed -E 's/^([^:]*): *# *include *(.*)$/\1: \2/')
ours() { printf '%s\n' "$includes" | grep -E "^$1[^:]*: <tilemesh/" | grep -vE ": <tilemesh/($2)" || true; }

# Layers: an arrow points to what may be included.
plain_names='(heat_image|html|image|image_file|json_text|number_text|plot|stacked_bars|string_stream|table|whole_file)'
plain_reports="report/($plain_names|detail/${plain_names}_code)\\.hpp"
while read -r part allowed; do
    refuse "$part includes only: $allowed" "$(ours "$part" "$allowed")"
done <<TEXT
config\\.hpp nothing
error\\.hpp nothing
joined_threads\\.hpp nothing
number_text\\.hpp config\\.hpp
machine/ machine/|config\\.hpp
splat/ splat/|machine/|config\\.hpp
engine/ engine/|machine/|config\\.hpp|error\\.hpp
model/ model/|engine/|machine/|config\\.hpp|error\\.hpp|number_text\\.hpp|$plain_reports
scene/ scene/|splat/|machine/|config\\.hpp|error\\.hpp|number_text\\.hpp
report/ report/|splat/|machine/|config\\.hpp|error\\.hpp|joined_threads\\.hpp|number_text\\.hpp
track/ track/|render/|engine/|scene/|report/|splat/|machine/|config\\.hpp|error\\.hpp|joined_threads\\.hpp
mapping/ mapping/|engine/|report/|scene/|splat/|machine/|config\\.hpp|error\\.hpp|joined_threads\\.hpp
slam/ slam/|mapping/|track/|scene/|report/|splat/|machine/|config\\.hpp|error\\.hpp
poplar/ poplar/|engine/|machine/|config\\.hpp|error\\.hpp
mpi/ mpi/|engine/|machine/|config\\.hpp|error\\.hpp
TEXT
refuse "tables, plots and pages know no splatting" "$(ours "$plain_reports" "$plain_reports|report/detail/large_memory\\.hpp|error\\.hpp|number_text\\.hpp|config\\.hpp")"
refuse "codelets include machine/, config.hpp and codelets" "$(ours "$codelet_code" "$codelet_code|machine/|config\.hpp")"
refuse "examples of codelets include codelets, splat/, machine/ and config.hpp" \
    "$(ours '\.\./\.\./examples/' "$codelet_code|splat/|machine/|config\.hpp")"
refuse "mpi/ and MPI are for mpi/ alone" "$(printf '%s\n' "$includes" | grep -v '^mpi/' | grep -E '<(tilemesh/mpi/|mpi\.h>)' || true)"
refuse "poplar/ and the SDK are for poplar/ alone" "$(printf '%s\n' "$includes" | grep -vE '^(poplar/|\.\./)' | grep -E '<(tilemesh/)?poplar/' || true)"
refuse "of libraries poplar/ includes the standard's and the SDK's" \
    "$(printf '%s\n' "$includes" | grep '^poplar/' | grep -vE ': <([a-z_]+|poplar/[A-Za-z]+\.hpp|tilemesh/.*)>$' || true)"
refuse "tilemesh.hpp is for users" "$(printf '%s\n' "$includes" | grep '<tilemesh/tilemesh.hpp>' || true)"
refuse "detail/ is for its own part" "$(printf '%s\n' "$includes" | grep -E '<tilemesh/[a-z]+/detail/' |
    grep -vE '^([a-z]+)/[^:]*: <tilemesh/\1/detail/' || true)"
refuse "machine/ and engine/ know no splatting, in comments either" "$(grep -niE 'gaussian|splat|pixel|bloom|camera|footprint|(^|[^a-z:])pairs?([^a-z]|$)' \
    machine/*.hpp engine/*.hpp || true)"
# A part's `detail` namespaces are its own: machine/ and the headers beside the folders have tilemesh::detail, model/ has model_detail,
# every other part PART::detail (poplar/: on_poplar::detail). Unqualified, a name must be declared by the part. No exceptions.
# shellcheck disable=SC2086
detail=$(grep -HoE '(([a-z_]+::)*|\b)(model_)?detail::[A-Za-z_]+' $all |
    sed -E 's/:(::)?tilemesh::/:tilemesh::/' | sort -u)
owners='engine|mpi|splat|scene|render|report|track|mapping|slam'
refuse "a part's detail is its own" "$(printf '%s\n' "$detail" | grep -E "^[^:]*:(tilemesh::)?($owners|on_poplar|model_detail|tilemesh::model_detail)::" |
    grep -vE '^([a-z]+)/[^:]*:(tilemesh::)?\1::detail::|^poplar/[^:]*:(tilemesh::)?on_poplar::detail::|^model/[^:]*:(tilemesh::)?model_detail::' || true)"
refuse "tilemesh::detail is for machine/ and the headers beside the folders" \
    "$(printf '%s\n' "$detail" | grep -E ':tilemesh::detail::' | grep -vE '^(machine/|[a-z_]+\.hpp:)' || true)"
refuse "a part's detail is its own (the part declares no such name)" "$(printf '%s\n' "$detail" | grep -E '^[^:]*:detail::' |
    while IFS= read -r use; do
        file=${use%%:*} name=${use##*:}
        case $file in */*) own=${file%%/*}/*.hpp ;; *) own=*.hpp ;; esac
        # shellcheck disable=SC2086
        grep -hwE "$name" $own $(case $file in */*) find "${file%%/*}" -mindepth 2 -name '*.hpp' ;; esac) |
            grep -qE "(struct|class|enum|using|namespace|[A-Za-z0-9_>\*&]) +\*?&?$name\b" || printf '%s\n' "$use"
    done)"
refuse "full paths, in angle brackets" "$(printf '%s\n' "$includes" | grep -v '^\.\./' | grep '"' || true)"
json='report/json(_frame)?\.hpp' # what only the users of nlohmann-json include
refuse "nlohmann-json is for $json" "$(printf '%s\n' "$includes" | grep nlohmann | grep -vE "^($json):" || true)"
refuse "$json are for users" "$(printf '%s\n' "$includes" | grep -E "<tilemesh/($json)>" | grep -vE "^($json): " || true)"
refuse "numbers are read by number_text.hpp" "$(grep -rnE '\b(sto(i|u?ll?|f|d)|strto(f|d|u?ll?)|from_chars|ato[ifl]|sscanf)\(' \
    --include='*.[ch]pp' . ../../examples ../../bench | grep -v '^./number_text.hpp:' || true)"
# shellcheck disable=SC2086
refuse "no #pragma once" "$(grep -L '^#pragma once' $all || true)"
# shellcheck disable=SC2086
refuse "lines over the limit of .clang-format" "$(awk -v most="$(sed -n 's/^ColumnLimit: //p' ../../.clang-format)" \
    'length > most { print FILENAME ":" FNR ": " length }' $all compiled/*.cpp)"
version=$(sed -nE 's/^#define TILEMESH_VERSION ([0-9]+).*/\1/p' config.hpp)
inside="namespace tilemesh \\{ inline namespace v$((version / 10000))_$((version / 100 % 100)) \\{"
# shellcheck disable=SC2086
refuse "every header opens the inline namespace of its version, but for the vertices that a graph finds by name" "$(
    { grep -HE '^ *(inline )?namespace tilemesh' $all compiled/*.cpp | grep -vE ":$inside( namespace [a-z_:]+ \\{)?(\\}\\})?\$"
      grep -LE "^$inside" $all | grep -vxF tilemesh.hpp; } | grep -vxE 'poplar/control_vertices\.hpp(:namespace tilemesh::vertices \{)?' || true)"
codecs='scene/codec_[a-z]+\.hpp' # each needs the library of a decoder
umbrella=$(sed -nE 's/^#include <tilemesh\/(.*)>$/\1/p' tilemesh.hpp)
refuse "missing in tilemesh.hpp" "$(printf '%s\n' $all | grep -E '^(machine|model|report|scene|track)/[a-z_]+\.hpp$' |
    grep -vxE "$json|$codecs" | grep -vxF "$umbrella" || true)"

# The list of public headers in README.md: each is there, and is of the umbrella header, directly or not, unless it needs another library.
# A header of a folder for users is on the list or inside; so are the headers that examples and consumers include.
inside='machine/(either|name|run_kernel|types)|model/parameter_file'
public=$(awk -F'|' '/^#/ { on = /^## Public headers/ } on && /^\| `/ {
    folder = $2
    gsub(/[` ]|tilemesh\//, "", folder)
    n = split($3, part, "`")
    for (i = 2; i <= n; i += 2) print folder part[i] }' README.md)
reached=tilemesh.hpp last=
while [ "$reached" != "$last" ]; do
    last=$reached
    reached=$(printf '%s\n' "$includes" | awk -v reached="$reached" '
        BEGIN { n = split(reached, all, "\n"); for (i = 1; i <= n; i++) { on[all[i]]; print all[i] } }
        { file = $1; sub(/:$/, "", file) }
        file in on && /<tilemesh\// { gsub(/.*<tilemesh\/|>.*/, ""); print }' | sort -u)
done
refuse "README.md: public headers twice" "$(printf '%s\n' "$public" | sort | uniq -d)"
refuse "README.md: public headers that are not there" "$(printf '%s\n' "$public" | grep -vxF "$all" || true)"
refuse "README.md: public headers that tilemesh.hpp does not include" \
    "$(printf '%s\n' "$public" | grep -vxE "$json|$codecs|(mapping|mpi|poplar|slam)/.*" | grep -vxF "$reached" || true)"
refuse "README.md: not among the public headers" "$({
    printf '%s\n' "$all" | grep -E '^[a-z_]+\.hpp$|^(machine|mapping|model|report|scene|slam|track)/[a-z_]+\.hpp$' | grep -vxE "(joined_threads|$inside)\.hpp"
    find ../../examples ../../tests/consumers -path ../../examples/c -prune -o -name '*.?pp' -exec sed -nE 's/^ *#include <tilemesh\/(.*)>$/\1/p' {} +
    } | sort -u | grep -vxF "$public" || true)"

# Kernel code: what it includes.
refuse "not among the headers of kernel code" "$(printf '%s\n' "$includes" | grep -E '^(config|machine/|splat/)' |
    grep -vE ": <($standard_headers|$glm_headers|tilemesh/.*)>\$" || true)"
refuse "not among the headers of codelets" "$(printf '%s\n' "$includes" | grep -E "^($codelet_code|\.\./)" |
    grep -vE ": (<($standard_headers|tilemesh/.*)>|\"\.\./heat/heat\.hpp\")\$|^poplar/(codelet|control_vertices)\.hpp: <poplar/Vertex\.hpp>\$" || true)"

# Kernel code: what it says. `code` prints "file:line:text" without comments and literals. A block comment may name a value on its line.
code() {
    for file in "$@"; do
        sed -E 's/"(\\.|[^"\\])*"/""/g; s,//.*$,,; s,/\*[a-z_]+\*/,,g' "$file" | grep -nE '[^ ]' | sed "s,^,$file:,"
    done
}
# shellcheck disable=SC2086
text=$(code $kernel_code $codelets)
says() { printf '%s\n' "$text" | grep -E "(^|[^A-Za-z0-9_])($1)([^A-Za-z0-9_]|\$)" || true; }
refuse "block comments that do more than name a value (this check reads lines)" "$(printf '%s\n' "$text" | grep -F '/*' || true)"
refuse "double precision" "$(says 'double')"
refuse "sizes are 32 bits" "$(says '(std::)?(size_t|ptrdiff_t|u?intptr_t)')"
# The ledger is added up in 64 bits at compile time, so that a huge program cannot wrap into a small one.
refuse "64-bit integers" "$(says '(std::)?u?int64_t|long' | grep -vE '^(machine/tile|splat/cell_masks|splat/fitted)\.hpp:' || true)"
refuse "not for tiles" "$(says 'virtual|throw|try|catch|new|delete|dynamic_cast|typeid|goto|mutable|thread_local|asm|std::(function|string|vector|sort|thread|atomic|mutex|chrono)')"
refuse "C++20 only" "$(says 'concept|requires|consteval|constinit|co_await|co_yield|co_return|std::(span|bit_cast|numbers)')"
# A host's form of a lens, in double; tiles have splat/bend.hpp.
refuse "library trigonometry costs thousands of cycles" "$(says '(std::)?(sin|cos|tan|asin|acos|atan|atan2|sinh|cosh|tanh|pow)f?' |
    grep -vE '^splat/lens(_point)?\.hpp:' || true)"
# The instruction set of a program on a host (splat/instruction_sets.hpp) is the exception; codelets have none.
refuse "statics that change" "$(printf '%s\n' "$text" | grep -oE '^[^:]*:[0-9]+|(^|[^A-Za-z_])static +[^(;={]*[;={]' |
    grep -vE '^[a-z_./]+\.[ch]pp:[0-9]+$' | grep -vE 'constexpr|^ static inline InstructionSet value =$' || true)"
refuse "unknown macros" "$(printf '%s\n' "$text" | sed -nE 's/^([^:]*:[0-9]+): *# *define ([A-Za-z_]+).*/\1 \2/p' |
    grep -vE ' TILEMESH_(VERSION|KERNEL|HOST|EXPECT|EXACT_BEGIN|EXACT_END|INSTRUCTION_SETS)$|^poplar/codelet\.hpp:[0-9]+ TILEMESH_(MULTI_)?VERTEX$' || true)"

refuse "test cases belong into .cpp files (ctest runs them file by file)" \
    "$(grep -lE '^ *TEST_CASE' "$1"/tests/*/*.hpp 2>/dev/null || true)"
exit $failed
