#!/bin/sh
# The last of three ranks ends in superstep 5. The launcher must say so and end the others within 60 s, with a status that is not 0.
# Usage: sh a_rank_dies.sh PATH_TO_tests_mpi_engine MPIRUN NUMBER_FLAG
set -u
log=$(mktemp) || exit 1
trap 'rm -f "$log"' EXIT
timeout -k 5 60 "$2" "$3" 3 "$1" --die </dev/null >"$log" 2>&1
status=$?
fail() {
    echo "FAILED: $*"
    cat "$log"
    exit 1
}
[ $status -ne 0 ] || fail "a rank died, and the job's status is 0"
[ $status -ne 124 ] && [ $status -ne 137 ] || fail "a rank died, and the job goes on"
for rank in 0 1 2; do
    grep -q "rank $rank is in superstep 4" "$log" || fail "rank $rank did not run up to superstep 4"
done
! grep -q 'goes on' "$log" || fail "ranks went on without the one that died"
# Open MPI says "... exited with exit code 3". MPICH's launcher may say nothing: its status joins 3 and the signal 9 by which it ends the others.
case $status in
3 | 9 | 11) ;;
*) grep -q -i -e 'exit code:* 3' -e '(exit status: *3)' "$log" || fail "the launcher does not name exit code 3, and its status is $status" ;;
esac
echo "a rank died, and the job ended with status $status"
