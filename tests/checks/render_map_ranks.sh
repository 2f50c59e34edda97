#!/bin/sh
# render_map over the ranks of MPI: the output of one process, errors once, and whole files when a rank dies.
# Usage: sh render_map_ranks.sh PATH_TO_render_map MPIRUN NUMBER_FLAG
# shellcheck source=render_map_common.sh
. "$(dirname "$0")/render_map_common.sh"
mpirun=$2 flag=$3
name=$(basename "$1" | cut -c 1-15) # as the system names its processes

# on RANKS ARGUMENTS...: as `run`, over ranks. What the launcher itself adds to standard error is left out.
on() {
    ranks=$1
    shift
    timeout -k 5 180 "$mpirun" "$flag" "$ranks" "$program" "$@" </dev/null >stdout 2>stderr_all
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
    what=$1
    shift
    run "$@" --float --program anchored --out one --report one.json >one.txt 2>one.err || [ $? -eq 1 ] || fail "one process: $*: $(cat one.err)"
    for ranks in 2 3; do
        on $ranks "$@" --float --out many --report many.json || fail "$what over $ranks ranks: status $?: $(cat stderr_all)"
        for file in one/*; do same "$file" "many/${file#one/}"; done
        exact many.json | sed 's/"program": "auto"/"program": "anchored"/' >many.exact
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
compare still --size 160x90 --threads 1
compare orbit --size 160x90 --threads 1 --orbit 3 --frames 3 --storage-slots 500 --grid 12x9
compare paper --size 160x90 --threads 2 --orbit 3 --frames 2 --preset paper --channel-slots 20 --copies screen --depth

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
refused '3 processes' --trace t
refused '3 processes' --engine sequential
refused '3 processes' --program homes
refused 'Gaussians' --storage-slots 1 --grid 4x4 --size 64x64
: >file
refused 'file' --out file/below --size 64x48
on 2 --version || fail "--version over ranks: $?"
[ "$(wc -l <stdout)" -eq 1 ] || fail "--version is written more than once"

# --- a rank dies: the job ends with a status, and files with their final names are whole ----------------
for victim in load first later; do
    "$mpirun" "$flag" 3 "$program" --size 640x360 --threads 1 --orbit 1 --frames 400 --quiet --out "$victim" --report "$victim.json" </dev/null >/dev/null 2>&1 &
    job=$!
    waits=0
    case $victim in
    load) until [ "$(pgrep -P $job | wc -l)" -ge 3 ] || [ $waits -ge 300 ]; do sleep 0.1; waits=$((waits + 1)); done ;;
    first) until [ -e $victim/frame_0000.png ] || [ $waits -ge 600 ]; do sleep 0.1; waits=$((waits + 1)); done ;;
    later) until [ -e $victim/frame_0003.png ] || [ $waits -ge 900 ]; do sleep 0.1; waits=$((waits + 1)); done ;;
    esac
    # The launcher's children are the ranks, or MPICH's proxy, whose children they are.
    ranks=$(pgrep -P $job -x "$name" || for child in $(pgrep -P $job); do pgrep -P "$child" -x "$name"; done)
    last=$(echo "$ranks" | tail -n 1)
    if [ -z "$last" ]; then
        fail "there is no rank to kill"
    else
        kill -KILL "$last"
    fi
    waits=0
    while kill -0 $job 2>/dev/null && [ $waits -lt 600 ]; do sleep 0.1; waits=$((waits + 1)); done
    kill -0 $job 2>/dev/null && { fail "a rank died ($victim), and the job goes on"; kill -KILL $job; }
    wait $job
    [ $? -ne 0 ] || fail "a rank died ($victim), and the job's status is 0"
    [ ! -e $victim.json ] || fail "a rank died ($victim), and there is a report"
    [ $victim = load ] || has_whole_pictures $victim
done

finish
