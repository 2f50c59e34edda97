#!/bin/sh
# render_map over the ranks of MPI: the output of one process, errors once, and whole files when a rank dies.
# Usage: sh render_map_ranks.sh PATH_TO_render_map MPIRUN NUMBER_FLAG LIBRARY_OF_tests/mpi/die
# shellcheck source=render_map_common.sh
. "$(dirname "$0")/render_map_common.sh"
mpirun=$2 flag=$3 die=$4
fault= # TILEMESH_DIE of the next runs over ranks (tests/mpi/die); empty: none

# on RANKS ARGUMENTS...: as `run`, over ranks. What the launcher itself adds to standard error is left out.
on() {
    ranks=$1
    shift
    timeout -k 5 180 "$mpirun" "$flag" "$ranks" ${fault:+env LD_PRELOAD="$die" TILEMESH_DIE="$fault"} "$program" "$@" </dev/null >stdout 2>stderr_all
    status=$?
    awk '/^-----/ { skip = !skip; next } /^=====/ { exit } !skip && NF' stderr_all | grep -v -e '^\[' -e '^Primary job' -e '^mpirun' >stderr
    return $status
}
# summary FILE: without times, the engine and the folder, which differ.
summary() { sed -e 's/[0-9.,]* ms//g' -e 's/threads, [0-9]* thread.*)/engine)/' -e 's/mpi, .* thread.*)/engine)/' -e '/host/d' -e '/wrote/d' "$1" | tr -s ' '; }
# exact FILE: of a report, without times, threads and the engine.
exact() { sed -e '/"host_ms"/,/}/d' -e '/"threads"/d' -e '/"engine"/d' -e '/"ranks"/d' -e '/"advice"/d' "$1"; }

# --- the output of one process --------------------------------------------------------------------
compare() {
    what=$1 of=$2
    shift 2
    run "$@" --float --program "$of" --out one --report one.json >one.txt 2>one.err || [ $? -eq 1 ] || fail "one process: $*: $(cat one.err)"
    for ranks in 2 3; do
        on $ranks "$@" --float --program "$of" --out many --report many.json || [ $? -eq 1 ] || fail "$what over $ranks ranks: status $?: $(cat stderr_all)"
        for file in one/*; do same "$file" "many/${file#one/}"; done
        exact many.json >many.exact
        exact one.json >one.exact
        same one.exact many.exact
        summary one.txt | grep -v -i -e 'built\|ms' >one.summary
        summary stdout | grep -v -i -e 'built\|ms' >many.summary
        has many.json '"engine": "mpi"'
        has many.json "\"ranks\": $ranks"
        [ "$(wc -l <one.summary)" -eq "$(wc -l <many.summary)" ] || fail "$what: the summary of $ranks ranks has other lines"
        rm -rf many many.json
    done
    rm -rf one one.json
}
compare still anchored --size 160x90 --threads 1
compare orbit anchored --size 160x90 --threads 1 --orbit 3 --frames 3 --storage-slots 500 --grid 12x9
compare paper anchored --size 160x90 --threads 2 --orbit 3 --frames 2 --preset paper --channel-slots 20 --copies screen --depth
compare homes homes --size 160x90 --threads 1 --orbit 3 --frames 2 --held 300 --grid 12x9
compare few_rows anchored --size 96x64 --threads 1 --orbit 3 --frames 2 --grid 30x2 # the third rank has no tile
compare few_rows_of_homes homes --size 96x64 --threads 1 --grid 60x2
compare planes homes --size 96x64 --threads 1 --depth --alpha --pixels rgbx8 --grid 12x9
# The anchored tiles of this map are full, so homes take over in the first frame.
compare auto auto --size 160x90 --threads 1 --orbit 3 --frames 2 --storage-slots 420 --grid 12x9

# --- maps in parts: each rank reads its rows --------------------------------------------------------
# ply ROWS [FIRST BAD ROW]: a 3DGS map in ASCII with ROWS rows. From the bad row on, every third row has a colour that is not finite.
ply() {
    echo "ply
format ascii 1.0
element vertex $1"
    for property in x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3 ${3:-}; do echo "property float $property"; done
    echo end_header
    awk -v n="$1" -v bad="${2:-0}" 'BEGIN { for (i = 1; i <= n; ++i) {
        g = (bad && i >= bad && (i - bad) % 3 == 0) ? "nan" : sin(i)
        printf "%.3f %.3f %.3f %s %.3f %.3f 2 -3 -3.2 -3.4 1 %.2f 0 0.1\n", 2 * sin(i * 12.9), 2 * sin(i * 78.2), 4 + sin(i * 3.7), g, sin(i * 2), sin(i * 3), sin(i) } }'
}
# binary FILE: the same rows as little-endian PLY.
binary() {
    python3 -c '
import struct, sys
text = open(sys.argv[1]).read().split("end_header\n")
sys.stdout.buffer.write((text[0].replace("ascii", "binary_little_endian") + "end_header\n").encode())
for line in text[1].splitlines(): sys.stdout.buffer.write(struct.pack("<14f", *map(float, line.split())))' "$1"
}
ply 500 >text.ply
ply 500 401 >bad.ply # the rejected rows are those of the last rank
compare ascii anchored text.ply --size 96x64 --threads 1 --orbit 3 --frames 2 --grid 8x6
compare rejected anchored bad.ply --size 96x64 --threads 1 --grid 8x6
compare joined auto text.ply bad.ply --turn x90 --size 96x64 --threads 1 --grid 8x6
if have_python; then
    binary bad.ply >binary.ply
    compare binary anchored binary.ply --size 96x64 --threads 1 --orbit 3 --frames 2 --grid 8x6
    compare homes_of_parts homes binary.ply --size 96x64 --threads 1 --grid 8x6
else
    skip "python3 is absent, so no binary map is read in parts"
fi

# --- errors once ----------------------------------------------------------------------------------
refused() {
    pattern=$1
    shift
    on 3 "$@"
    is_refusal $? "$pattern"
    [ ! -s stdout ] || fail "standard output of: $*"
}
refused 'unknown option\|--nonsense' --nonsense
refused 'no.ply' no.ply
sed '/end_header/q' text.ply >cut.ply
refused 'cut.ply is too short' cut.ply
awk '{ print } /end_header/ { body = NR } body && NR == body + 450 { print "1 2 3" }' text.ply >short.ply
refused 'short.ply cannot be read' short.ply
refused '3 processes' --trace t
refused '3 processes' --engine sequential
refused 'Gaussians' --program anchored --storage-slots 1 --grid 4x4 --size 64x64
: >file
refused 'file' --out file/below --size 64x48
# One rank has no memory, or rank 0 no disk: one line, status 2, the file of the picture before, and no other.
fails() {
    fault=$1 pattern=$2 of=$3
    rm -rf failing failing.json
    mkdir failing
    on 3 text.ply --program "$of" --size 160x90 --threads 1 --orbit 1 --frames 4 --grid 12x9 --quiet --float --out failing --report failing.json
    is_refusal $? "$pattern"
    fault=
    [ ! -e failing.json ] || fail "$1, and there is a report"
    for file in failing/*.p??; do
        [ ! -e "$file" ] || same "$file" "whole_$of/${file##*/}"
    done
    has_no_parts failing
}
for of in anchored homes; do
    run text.ply --program $of --size 160x90 --threads 1 --orbit 1 --frames 4 --grid 12x9 --quiet --float --out whole_$of 2>/dev/null
    fails '0 disk 3' 'No space left on device' $of
    [ "$(find failing -name '*.png' | wc -l)" -eq 1 ] || fail "$of, full disk: $(ls failing)"
    for n in 1 2 4 8; do
        fails "2 memory $n" 'out of memory' $of
    done
done

on 2 --version || fail "--version over ranks: $?"
[ "$(wc -l <stdout)" -eq 1 ] || fail "--version is written more than once"

# --- a rank dies: the job ends with a status, and files with their final names are whole ----------------
# dies PHASE RANK PLACE N: rank RANK gets SIGKILL when it comes to this place the N-th time (tests/mpi/die).
dies() {
    phase=$1
    shift
    timeout -k 5 120 "$mpirun" "$flag" 3 env LD_PRELOAD="$die" TILEMESH_DIE="$*" "$program" text.ply --program "$of" --size 160x90 --threads 1 \
        --orbit 1 --frames 4 --grid 12x9 --quiet --float --out "$phase" --report "$phase.json" </dev/null >/dev/null 2>stderr_all
    status=$?
    [ $status -ne 0 ] || fail "a rank died ($phase), and the job's status is 0"
    [ $status -ne 124 ] || fail "a rank died ($phase), and the job goes on"
    [ ! -e "$phase.json" ] || fail "a rank died ($phase), and there is a report"
    pictures=$(find "$phase" -name '*.png' 2>/dev/null | wc -l)
    for file in "$phase"/*.p??; do # PNG and PFM
        [ ! -e "$file" ] || same "$file" "whole_$of/${file##*/}"
    done
}
# pictures PHASE LEAST MOST: how many are whole when the job ends.
pictures() {
    if [ "$pictures" -lt "$2" ] || [ "$pictures" -gt "$3" ]; then fail "a rank died ($1), and there are $pictures pictures, not $2 to $3"; fi
}
for of in anchored homes; do
    dies load_$of 2 MPI_Bcast 3
    pictures load_$of 0 0
    dies load_of_first_$of 0 MPI_Bcast 3
    pictures load_of_first_$of 0 0
    dies deal_$of 1 MPI_Alltoallv 2 # the records go to the ranks of their tiles
    pictures deal_$of 0 0
    dies route_$of 1 MPI_Isend 3
    pictures route_$of 0 0
    case $of in
    anchored) dies gather_$of 2 items 5 ;; # the outline of the map, then the rows of each picture
    homes) dies gather_$of 2 states 7 ;;   # the rank has 3 of 9 rows of tiles, so this is frame 3
    esac
    pictures gather_$of 1 3
    dies write_$of 0 write 3
    pictures write_$of 0 3
    find write_$of -name '*.part' | grep -q . || fail "no file was being written when the rank died"
    dies rename_$of 0 rename 3
    pictures rename_$of 1 3
done

finish
