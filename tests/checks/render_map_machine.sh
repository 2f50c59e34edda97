#!/bin/sh
# What render_map --machine FILE promises: mk2.txt is Mk2, by both programs; smaller machines give smaller capacities, and the ledger fits;
# unknown numbers are named; a network's lines price a frame; whatever does not fit, and every bad file, is refused in one line.
# Usage: sh render_map_machine.sh PATH_TO_render_map FOLDER_OF_machines
case $2 in /*) machines=$2 ;; *) machines=$PWD/$2 ;; esac
# shellcheck source=render_map_common.sh
. "$(dirname "$0")/render_map_common.sh"
small="--size 160x90 --quiet"

# --- mk2.txt is Mk2 --------------------------------------------------------------------------------
# shellcheck disable=SC2086 # $small and $options are several words
for options in "" "--program homes" "--preset paper --program anchored" "--depth"; do
    runs $small $options --machine mk2 --out known --trace known --report known.json --float
    runs $small $options --machine "$machines/mk2.txt" --out file --trace file --report file.json --float
    same known/frame_0000.pfm file/frame_0000.pfm
    same known/frame_0000.supersteps.csv file/frame_0000.supersteps.csv
    equal "cycles of $options" "$(counter file.json cycles 0)" "$(counter known.json cycles 0)"
    equal "machine's bytes of $options" "$(counter file.json budgeted_bytes 0)" "$(counter known.json budgeted_bytes 0)"
    equal "slots of $options" "$(counter file.json storage_slots 0)" "$(counter known.json storage_slots 0)"
done
has file.json 'machine mk2: .* documented; .*guessed: barrier, vote, exchange_start; unknown: none'
has file/report.html 'guessed: barrier, vote, exchange_start; unknown: none'

# --- other machines --------------------------------------------------------------------------------
# A third of the SRAM: the channels have a third of the slots, and the tile is full.
sed -E 's/^machine .*/machine third/; s/^sram +638976 (.*)/sram 301738 \1/' "$machines/mk2.txt" >third.txt
runs $small --machine third.txt --out third --report third.json --program anchored --fit off
has third.json '"name": "third"'
equal "a third of 200 slots" "$(counter third.json channel_slots 0)" 66
awk -v b="$(counter third.json budgeted_bytes 0)" 'BEGIN { exit !(b <= 301738 && b + 136 > 301738) }' ||
    fail "the ledger has $(counter third.json budgeted_bytes 0) of 301,738 bytes"
runs $small --machine third.txt --out third --report third.json --program anchored --fit off --channel-slots 20
equal "asked slots" "$(counter third.json channel_slots 0)" 20
runs $small --machine third.txt --out homes --report homes.json --program homes
awk -v b="$(counter homes.json budgeted_bytes 0)" 'BEGIN { exit !(b <= 301738) }' || fail "homes have more than the tile"
# Twice the SRAM is not used, and the report says so.
sed -E 's/^machine .*/machine double/; s/^sram +638976 (.*)/sram 1277952 \1/' "$machines/mk2.txt" >double.txt
runs $small --machine double.txt --out double --report double.json
has double.json "of a tile's 1,277,952 bytes stay free"
# Homes that fit keep their sizes on a smaller machine, and the note has what the ledger leaves.
sed -E 's/^machine .*/machine half/; s/^sram +638976 (.*)/sram 524288 \1/' "$machines/mk2.txt" >half.txt
runs $small --machine half.txt --out half --report half.json --program homes
equal "slots of homes that fit" "$(counter half.json storage_slots 0) $(counter half.json channel_slots 0)" "2800 120"
free=$(printf '%s' "$((524288 - $(counter half.json budgeted_bytes 0)))" | sed -E 's/([0-9]+)([0-9]{3})$/\1,\2/')
has half.json "\"$free of a tile's 524,288 bytes stay free: preset "
# Its grid is that of the file, and a tile has as many pixels as the frame asks for.
runs $small --machine "$machines/gpu_sm.txt" --out gpu --report gpu.json --trace gpu
has gpu/report.html 'machine gpu-sm'
has gpu.json '"cost_model": "gpu-sm"'
tr -d ' \n' <gpu.json >flat.json
has flat.json '"grid":\[12,11\]'
runs $small --machine "$machines/mk1.txt" --out mk1 --report mk1.json --trace mk1
has mk1.json 'at least: without barrier, vote, exchange_start, host_link'
# The wafer's network prices a part of it, and the model reads back.
runs --size 80x48 --quiet --machine "$machines/wse2.txt" --grid 40x24 --program homes --out wafer --report wafer.json --trace wafer
has wafer/model.txt '^network *mesh'
has wafer/model.txt '^network.link *4 '
runs --size 80x48 --quiet --machine "$machines/wse2.txt" --grid 40x24 --program homes --out again --report again.json --trace again --cost-model wafer/model.txt
equal "cycles by the written model" "$(counter again.json cycles 0)" "$(counter wafer.json cycles 0)"

# --- what it refuses -------------------------------------------------------------------------------
refuses 'a grid of 850,000 tiles is too large' $small --machine "$machines/wse2.txt"
refuses 'machine scamp-5, region .* has [0-9]* bytes, and the sum is [0-9]* bytes over' $small --machine "$machines/scamp5.txt"
refuses 'does not fit' $small --machine "$machines/scamp5.txt" --program homes
refuses 'there are mk2, test' $small --machine mk3
refuses 'cannot read the machine ./none.txt' $small --machine ./none.txt
refuses 'cannot read the machine .* (it is a directory)' $small --machine "$machines/"
refuses 'gpu-sm has 132' $small --machine "$machines/gpu_sm.txt" --grid 40x36
sed 's/^sram .*/sram unknown bytes nobody said/' "$machines/mk2.txt" >bad.txt
refuses 'its sram is unknown: nobody said' $small --machine bad.txt
sed 's/^workers .*/workers 7 workers guess/' "$machines/mk2.txt" >bad.txt
refuses '7 workers' $small --machine bad.txt
sed 's/^sram /srma /' "$machines/mk2.txt" >bad.txt
refuses 'bad.txt line [0-9]* has an unknown parameter ("srma")' $small --machine bad.txt
sed '/^clock /d' "$machines/mk2.txt" >bad.txt
refuses 'parameter clock is missing' $small --machine bad.txt
: >bad.txt
refuses 'it holds no machine' $small --machine bad.txt
cp "$machines/mk2.txt" report.json
refuses 'the report' $small --machine report.json --report report.json
same "$machines/mk2.txt" report.json
has_no_parts .
finish
