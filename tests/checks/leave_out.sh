#!/bin/sh
# usage: leave_out.sh COMPILER NM OBJDUMP INCLUDE FOLDER
# What a setup does without costs no instruction and leaves no symbol, at -O2, for any machine and for one with AVX2:
#   1. the smallest frame's projection kernel has at most 3 % more instructions than leave_out/by_hand.cpp, which knows no feature
#      (a compiler that inlines the projection into either may spill another register);
#   2. what a setup of one colour a record compiles to is the same to the byte where one with harmonics and planes stands beside it;
#   3. no symbol of a feature is in the kernels of a setup without it, not even before the optimiser has looked, and none of a trace in
#      the engines of a machine that keeps none, with the compiled library (instructions.sh has the rest: the same bytes without what only a trace calls).
# Objects go to FOLDER. Prints the sizes of what it compared.
set -eu
export LC_ALL=C
compiler=$1 nm=$2 objdump=$3 include=$4 folder=$5
failed=0
mkdir -p "$folder"

compile() { # NAME SOURCE FLAGS...: FOLDER/NAME.o; each function in a section of its own, without padding behind it
    name=$1 source=$2
    shift 2
    "$compiler" -std=c++20 -Wall -Wextra -Werror -ffunction-sections "$@" -I "$include" -c "leave_out/$source.cpp" -o "$folder/$name.o"
}
# GNU's and LLVM's objdump: "<name>:" before a function, "address: bytes  instruction" in it.
# shellcheck disable=SC2016
listing='
    function flush() { if (name != "") print name " " code; name = code = "" }
    / <.*>:$/ { flush(); name = $0; sub(/^[0-9a-f]+ /, "", name); next }
    /^ *[0-9a-f]+:/ {
        sub(/^ *[0-9a-f]+:[ \t]*/, "")
        bytes = ""
        while (match($0, /^[0-9a-f][0-9a-f]([ \t]+|$)/)) { bytes = bytes substr($0, 1, 2); $0 = substr($0, RLENGTH + 1) }
        code = code " " (want_bytes ? bytes : $1)
    }
    END { flush() }'
instructions() { # OBJECT FUNCTION: the names of the instructions of the one function that is called so, a line each
    "$objdump" -d -C "$folder/$1.o" | awk -v want_bytes=0 "$listing" | grep "::$2[(<]" | grep -v '\[clone' >"$folder/found.txt" || true
    if [ "$(wc -l <"$folder/found.txt")" -ne 1 ]; then echo "not one function $2 in $1.o" >&2 && exit 1; fi
    sed 's/.*>: //' "$folder/found.txt" | tr ' ' '\n' | grep .
}
functions() { # OBJECT: a line for each function: its name, then its bytes; addresses of others are not in them
    "$objdump" -d "$folder/$1.o" | awk -v want_bytes=1 "$listing" | sort
}
size() { # OBJECT FUNCTION
    "$nm" -SC "$folder/$1.o" | awk -v name="::$2[(<]" '$3 ~ /[TWt]/ && $0 ~ name && !/\[clone/ { print $2 }' | head -1
}

# 1. By hand.
compare() { # FUNCTION, in FLAGS
    instructions library "$1" >"$folder/library.txt"
    instructions by_hand "$1" >"$folder/by_hand.txt"
    printf '%-16s %-13s 0x%s bytes, by hand 0x%s; %s instructions\n' "$flags" "$1" "$(size library "$1" | sed 's/^0*//')" \
        "$(size by_hand "$1" | sed 's/^0*//')" "$(wc -l <"$folder/library.txt" | tr -d ' ')"
    if [ "$(wc -l <"$folder/library.txt")" -gt $(($(wc -l <"$folder/by_hand.txt") * 103 / 100)) ]; then
        diff "$folder/library.txt" "$folder/by_hand.txt" | head -20 || true
        echo "$1: more instructions than by hand, $(wc -l <"$folder/by_hand.txt" | tr -d ' ')"
        failed=1
    fi
}
# 2. Beside everything. Each setup stands beside a twin in its own unit, because GCC inlines what has a single caller.
contained() { # UNIT LARGER_UNIT
    functions "$1" | grep -v Twin >"$folder/alone.txt"
    functions "$2" >"$folder/beside.txt"
    changed=$(comm -23 "$folder/alone.txt" "$folder/beside.txt" | sed 's/ .*//')
    printf '%-16s %s: %s functions, the same bytes in %s\n' "$flags" "$1" "$(wc -l <"$folder/alone.txt" | tr -d ' ')" "$2"
    if [ -n "$changed" ] || [ ! -s "$folder/alone.txt" ]; then
        echo "$changed: other bytes where $2 stands beside"
        failed=1
    fi
}
every="-O2"
if printf '' | "$compiler" -march=x86-64-v3 -x c++ -c - -o "$folder/empty.o" 2>/dev/null; then every="$every -O2:-march=x86-64-v3"; fi
for flags in $every; do
    flags=$(echo "$flags" | tr ':' ' ')
    # shellcheck disable=SC2086
    {
        compile library minimal $flags
        compile by_hand by_hand $flags
        compile projection projection $flags
        compile projection_shaded projection $flags -DSHADED
        compile lossless kernels_of $flags -DSETUP=Lossless '-DBESIDE=Twin<Lossless>'
        compile lossless_beside kernels_of $flags -DSETUP=Lossless -DBESIDE=everything
        compile minimal kernels_of $flags -DSETUP=minimal '-DBESIDE=Twin<minimal>'
        compile minimal_beside kernels_of $flags -DSETUP=minimal -DBESIDE=everything
    }
    compare project_tile
    contained projection projection_shaded
    contained lossless lossless_beside
    contained minimal minimal_beside
done

# 3. Symbols: unoptimised, so that nothing is inlined away.
symbols() { # SOURCE FLAGS...
    compile names "$@"
    "$nm" -C "$folder/names.o" >"$folder/names.txt"
}
none_has() { # WHAT WORDS
    if grep -E "$2" "$folder/names.txt"; then
        echo "$1: a symbol of what it does without"
        failed=1
    fi
    printf '%-16s %s: %s symbols, none has %s\n' -O0 "$1" "$(wc -l <"$folder/names.txt" | tr -d ' ')" "$2"
}
each_is_there() { # WHAT WORD...
    what=$1
    shift
    for word in "$@"; do
        grep -qE "$word" "$folder/names.txt" || { echo "no symbol of $what has $word: this check looks for a name that is none" && failed=1; }
    done
}
lacks() { # SETUP WORDS
    symbols kernels_of -O0 -DSETUP="$1"
    none_has "$1" "$2"
}
routing='Route|Road|Waiting|FlowControl'
bloom='Bloom|Beam|OwedCopies|is_child'
harmonics='harmonic_basis|ShadedGaussian'
planes='DepthBlock|WithDepth|WithAlpha'
lacks minimal "$routing|$bloom|$harmonics|$planes"
lacks with_bloom "$routing|$harmonics|$planes"
lacks with_routing "$bloom|$harmonics|$planes"
lacks Lossless "$harmonics|$planes"
lacks degree_1 "$planes"
symbols kernels_of -O0 -DSETUP=everything
# shellcheck disable=SC2046
each_is_there everything $(echo "$routing|$bloom|$harmonics|$planes" | tr '|' ' ')
operations='::operations\(' trace='tilemesh::v[0-9_]+::Trace([^A-Za-z]|$)'
symbols mesh_of -O0 -DTILEMESH_COMPILED -DMACHINE=Mk2
none_has "engines on Mk2" "$operations|TileSample|SuperstepSample|$trace"
symbols mesh_of -O0 -DTILEMESH_COMPILED '-DMACHINE=Traced<Mk2>'
each_is_there "a machine with a trace" "$operations" TileSample SuperstepSample "$trace"
exit $failed
