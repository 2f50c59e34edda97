#!/bin/sh
# usage: codelets.sh COMPILER PROJECT FOLDER [CODELETS]
# The codelet file (examples/on_poplar/codelets.cpp) as an IPU's compiler would take it, by Clang 16, the LLVM of Poplar 3.3: C++17 and
# C++20, for this machine and for a 32-bit one that has single precision in hardware and nothing wider, so that a size_t, a double and
# a 64-bit division show. Headers are PROJECT/include and PROJECT/examples, Poplar's are the stand-in's. What it compiles to has
#   no call through a pointer, no recursion (a worker's stack is a number), no double, no atomics, no data that changes,
#   and needs nothing of a library but mem* and sqrtf.
# Prints the bytes of code and of stack of each program (the part of its vertices' names before the first _). What another compiler
# makes of them differs; the limits have room for that.
set -eu
export LC_ALL=C
compiler=$1 project=$2 folder=$3 codelets=${4-$2/examples/on_poplar/codelets.cpp}
here=$(cd "$(dirname "$0")" && pwd)
# shellcheck source-path=SCRIPTDIR source=kernel_headers.sh
. "$here/kernel_headers.sh"
if ! command -v "$compiler" >/dev/null 2>&1; then echo "skipped: clang++-16 is absent" && exit 0; fi

# Limits. A tile's reserve for code and stacks is 130 KiB (Mk2::code_bytes) and has to hold six workers' stacks, the code, and what is
# not compiled here: exchange code, the vertices' state, Poplar's own. That keeps a quarter.
frame_limit=4096   # bytes a function: compositing has two cells of pixels and 16 splats, 3.4 KB
stack_limit=6144   # bytes a worker, from its vertex down: 36 KiB for six
reserve=133120
workers=6

standin=$(cd "$here/../poplar/standin" && pwd)

failed=0
refuse() { # a reason, then what was found, a line each (nothing: all is well)
    if [ -n "$2" ]; then printf '%s\n' "$2" | awk -v why="$1" '{ print why ": " $0 }' && failed=1; fi
}
tools=$(dirname "$(readlink -f "$(command -v "$compiler")")")
nm=$tools/llvm-nm
plain() { "$tools/llvm-cxxfilt" | sed -E 's/tilemesh::(v[0-9_]+::)?//g' | cut -c 1-160; }
for tool in "$nm" "$tools/llvm-cxxfilt"; do
    if [ ! -x "$tool" ]; then echo "skipped: $tool is absent" && exit 0; fi
done
mkdir -p "$folder/none/gnu"
# The C library's headers of this machine serve the other one too, but for these lists of what is missing in it.
for abi in 32 ilp32 ilp32f; do : >"$folder/none/gnu/stubs-$abi.h"; done

# Every vertex has its compute called, as Poplar's loader would.
vertices=$(sed -nE 's/^TILEMESH_VERTEX\(([A-Za-z_0-9]+),.*/\1 0/p; s/^TILEMESH_MULTI_VERTEX\(([A-Za-z_0-9]+),.*/\1 1/p' "$codelets"
    sed -nE 's/^class ([A-Za-z_0-9]+) : public ::poplar::Vertex \{$/tilemesh::vertices::\1 0/p' "$project/include/tilemesh/poplar/control_vertices.hpp")
all=$folder/all_vertices.cpp
{
    echo "#include \"$codelets\""
    printf '%s\n' "$vertices" | while read -r name multi; do
        function="bool vertex__$(echo "$name" | sed 's/tilemesh::vertices::/votes_/')($name& v, unsigned worker) noexcept"
        if [ "$multi" = 1 ]; then body='v.compute(worker)'; else body='(static_cast<void>(worker), v.compute())'; fi
        echo "extern \"C\" $function;"
        echo "$function { return $body; }"
    done
} >"$all"

# What it includes: every file of ours that was read.
"$compiler" -std=c++17 -I "$project/include" -I "$project/examples" -isystem "$standin" -MM "$all" 2>/dev/null |
    tr -d '\\' | tr ' ' '\n' | grep -F -e "$project/" -e "$codelets" | sort -u >"$folder/files"
xargs grep -HE '^ *# *include' <"$folder/files" | sed -E "s,^$project/,,; s,: *# *include *,: ," >"$folder/includes"
refuse "not a header of kernel code" "$(grep -vE ": (<($standard_headers|$glm_headers|tilemesh/[^>]*|poplar/Vertex\.hpp)>|\"[^\"]*\")" "$folder/includes" || true)"
[ $failed -eq 0 ] || exit 1

# Compiles with these further arguments. The first error is enough.
flags="-fno-exceptions -fno-rtti -Wall -Wextra -Wconversion -Wshadow -Wdouble-promotion -Wshorten-64-to-32 -pedantic -Werror -DNDEBUG -D__POPC__"
compile() {
    # shellcheck disable=SC2086
    if ! "$compiler" $flags -I "$project/include" -I "$project/examples" -isystem "$standin" "$@" >"$folder/log" 2>&1; then
        refuse "does not compile" "$(grep -m 1 -E 'error:' "$folder/log" || head -n 1 "$folder/log")"
        return 1
    fi
}
system=$(echo | "$compiler" -x c++ -E -v - 2>&1 | sed -n '/^#include </,/^End/s/^ //p' | grep -v '/lib/clang/')
# With what our headers take for an IPU: two lanes, fused multiplication.
other_machine="-D__IPU__ --target=riscv32-unknown-linux-gnu -march=rv32imf -mabi=ilp32f -msmall-data-limit=0 -nostdinc++ -isystem $folder/none"
for path in $system; do other_machine="$other_machine -isystem $path"; done
# shellcheck disable=SC2086
{
    for standard in 17 20; do
        compile -std=c++$standard -fsyntax-only "$all" || exit 1
        compile $other_machine -std=c++$standard -fsyntax-only "$all" || exit 1
    done
    compile $other_machine -std=c++17 -O0 -S -emit-llvm "$all" -o "$folder/O0.ll" || exit 1
    compile $other_machine -std=c++17 -O2 -S -emit-llvm "$all" -o "$folder/O2.ll" || exit 1
    compile --target=riscv32-unknown-linux-gnu -march=rv32imf -mabi=ilp32f -O2 -Xclang -disable-llvm-passes -ffunction-sections \
        -fstack-usage -Wno-unused-command-line-argument -c "$folder/O2.ll" -o "$folder/codelets.o" || exit 1
}

# What is in it, before the optimiser has looked.
ir=$folder/O0.ll
# functions_with PATTERN [WITHOUT]: those with a line of code that is so.
functions_with() {
    awk -v with="$1" -v without="${2:-^$}" '
        /^define / { match($0, /@[A-Za-z0-9_.$]+\(/); name = substr($0, RSTART + 1, RLENGTH - 2) }
        $0 ~ with && $0 !~ without && name != said { print name; said = name }' "$ir" | plain
}
refuse "a call through a pointer (virtual, or a function pointer) or assembly in" "$(functions_with '^ .*(call|invoke) ' '@[A-Za-z0-9_.$]+\\(')"
refuse "double precision in" "$(functions_with '^(define| ).*[^A-Za-z0-9_.%@"]double[^A-Za-z0-9_.]')"
refuse "atomics in" "$(functions_with '^ .*(atomicrmw|cmpxchg|fence|(load|store) atomic) ')"
refuse "data that changes" "$(sed -nE 's/^@([A-Za-z0-9_.$]+) = (.* )?global .*/\1/p' "$ir" | plain)"

# "caller callee" for each call.
calls() {
    awk '
    /^define / { match($0, /@[A-Za-z0-9_.$]+\(/); name = substr($0, RSTART + 1, RLENGTH - 2) }
    /^ .*(call|invoke) / && match($0, /@[A-Za-z0-9_.$]+\(/) {
        callee = substr($0, RSTART + 1, RLENGTH - 2)
        if (callee !~ /^llvm\./ && !((name, callee) in seen)) { seen[name, callee] = 1; print name, callee }
    }' "$1"
}
recursion=$(calls "$ir" | awk '
    { callees[$1] = callees[$1] " " $2 }
    function visit(f,    n, i, list) {
        state[f] = 1
        n = split(callees[f], list, " ")
        for (i = 1; i <= n; ++i) {
            if (!(list[i] in state)) visit(list[i])
            else if (state[list[i]] == 1) { print list[i]; exit }
        }
        state[f] = 2
    }
    END { for (f in callees) if (!(f in state)) visit(f) }' | plain)
refuse "recursion through" "$recursion"

# What the object needs.
allowed='mem(cpy|move|set|cmp)|sqrtf' # a square root is an instruction of an IPU; this one asks a library when it must set errno
refuse "needs of a library" "$("$nm" -u "$folder/codelets.o" | awk '{ print $NF }' | grep -vxE "$allowed" | plain)"
refuse "a frame whose size is not known" "$(awk -F'\t' '$3 != "static" { n = split($1, part, ":"); print part[n] }' "$folder/codelets.su" | plain)"
[ $failed -eq 0 ] || exit 1

# Code and stacks: of each program the sum of the functions that its vertices reach, and the largest sum of frames on a way down.
{
    awk '{ n = split($1, part, ":"); print "frame", part[n], $2 }' "$folder/codelets.su"
    "$nm" -S "$folder/codelets.o" | awk '$3 ~ /^[TtWw]$/ && NF == 4 { print "code", $4, $2 }'
    calls "$folder/O2.ll" | sed 's/^/call /'
} >"$folder/facts"
awk -v frame_limit=$frame_limit -v stack_limit=$stack_limit -v reserve=$reserve -v workers=$workers '
    function hex(text,    i, value) {
        for (i = 1; i <= length(text); ++i) value = 16 * value + index("0123456789abcdef", substr(text, i, 1)) - 1
        return value
    }
    $1 == "frame" { frame[$2] = $3; if ($3 > largest) { largest = $3; of = $2 } }
    $1 == "code" { code[$2] = hex($3) }
    $1 == "call" { callees[$2] = callees[$2] " " $3 }
    function stack(f,    n, i, list, deepest, s) {
        if (f in known) return known[f]
        n = split(callees[f], list, " ")
        for (i = 1; i <= n; ++i) { s = stack(list[i]); if (s > deepest) deepest = s }
        return known[f] = frame[f] + deepest
    }
    function reach(f, program,    n, i, list) {
        if ((f, program) in reached) return
        reached[f, program] = 1
        bytes[program] += code[f]
        n = split(callees[f], list, " ")
        for (i = 1; i <= n; ++i) reach(list[i], program)
    }
    END {
        for (f in code) if (f ~ /^vertex__/) {
            split(substr(f, 9), part, "_")
            program = part[1]
            reach(f, program)
            s = stack(f)
            if (s > deepest[program]) { deepest[program] = s; at[program] = substr(f, 9) }
            ++vertices
        }
        for (program in bytes) {
            sum = bytes[program] + workers * deepest[program]
            printf "%-10s %6d bytes of code; stack %5d bytes (%s); with %d stacks %6d of %d bytes\n", program ":", bytes[program],
                deepest[program], at[program], workers, sum, reserve
            if (deepest[program] > stack_limit) { print program ": a stack above " stack_limit " bytes"; bad = 1 }
            if (sum > reserve / 4 * 3) { print program ": code and stacks are above three quarters of the reserve"; bad = 1 }
        }
        if (largest > frame_limit) { print "a frame above " frame_limit " bytes: " of; bad = 1 }
        printf "%d vertices; the largest frame has %d bytes\n", vertices, largest
        if (vertices == 0) { print "no vertices found"; bad = 1 }
        exit bad
    }' "$folder/facts" || failed=1
size=$("$tools/llvm-size" "$folder/codelets.o" | awk 'NR == 2 { print $1 }')
echo "$size bytes of code and constants in all; needs $("$nm" -u "$folder/codelets.o" | awk '{ printf "%s%s", sep, $NF; sep = ", " }')"
exit $failed
