#!/bin/sh
# What pfm_error says of small pictures whose errors are known, and what it refuses with one line and status 2.
# Usage: sh pfm_error.sh PATH_TO_pfm_error
set -u
LC_ALL=C
export LC_ALL
case $1 in
/*) program=$1 ;;
*) program=$PWD/$1 ;;
esac
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
failures=0
fail() {
    echo "FAILED: $*"
    failures=$((failures + 1))
}

# pfm FILE WIDTH HEIGHT ORDER WORD...: a colour PFM whose channel values are the words, eight hexadecimal digits each.
pfm() {
    if [ "$4" = little ]; then scale=-1.0; else scale=1.0; fi
    printf 'PF\n%s %s\n%s\n' "$2" "$3" $scale >"$1"
    file=$1 order=$4
    shift 4
    # shellcheck disable=SC2059
    printf "$(echo "$*" | awk -v order="$order" '
        function value(digit) { return index("0123456789abcdef", digit) - 1 }
        {
            for (i = 1; i <= NF; ++i)
                for (k = 0; k < 4; ++k) {
                    at = 1 + 2 * (order == "little" ? 3 - k : k)
                    printf "\\%03o", 16 * value(substr($i, at, 1)) + value(substr($i, at + 1, 1))
                }
        }')" >>"$file"
}
# repeated COUNT WORD...: the words so often.
repeated() { echo "$@" | awk '{ for (n = 0; n < $1; ++n) for (i = 2; i <= NF; ++i) print $i }'; }

# says EXPECTED ARGUMENTS...: status 0, nothing on standard error, and the nine values in order.
says() {
    expected=$1
    shift
    "$program" "$@" >stdout 2>stderr </dev/null || fail "status $? of: $*: $(cat stderr)"
    [ ! -s stderr ] || fail "standard error of: $*: $(cat stderr)"
    [ "$(awk '{ print $1 }' stdout | tr '\n' ' ')" = "$names " ] || fail "the names of $* are $(cat stdout)"
    values=$(awk '{ print $2 }' stdout | tr '\n' ' ')
    [ "$values" = "$expected " ] || fail "$*: $values, not $expected"
}
names="rmse max_levels p999_levels psnr_db ssim mae share_over_one_level max_x max_y"

# refuses PATTERN ARGUMENTS...: status 2, nothing on standard output, and one line "<problem> (<why>); <what to do>".
refuses() {
    pattern=$1 status=0
    shift
    "$program" "$@" >stdout 2>stderr </dev/null || status=$?
    [ $status -eq 2 ] || fail "status $status, not 2, of: $*"
    [ ! -s stdout ] || fail "standard output of: $*"
    [ "$(wc -l <stderr)" -eq 1 ] || fail "not one line: $*: $(cat stderr)"
    grep -q '^[^(].* (.*); .' stderr || fail "not \"problem (why); what to do\": $(cat stderr)"
    grep -q -e "$pattern" stderr || fail "\"$pattern\" is not in: $(cat stderr)"
}

# 0, 1/255, 1/4, 1/2, 1, -1, NaN, infinity.
zero=00000000 level=3b808081 quarter=3e800000 half=3f000000 one=3f800000 minus=bf800000 nan=7fc00000 infinity=7f800000

# --- known answers -----------------------------------------------------------------------------
# shellcheck disable=SC2046
{
    pfm black.pfm 4 3 little $(repeated 36 $zero)
    pfm level.pfm 4 3 little $(repeated 36 $level)
    pfm level_big.pfm 4 3 big $(repeated 36 $level)
    pfm colours.pfm 2 2 little $(repeated 3 $quarter $half $one $minus)
    pfm colours_big.pfm 2 2 big $(repeated 3 $quarter $half $one $minus)
}
[ "$(wc -c <black.pfm)" -eq $((12 + 144)) ] || fail "this script writes no PFM"

says "0.0000e+00 0.0000 0.0000 inf 1.000000 0.0000e+00 0.000000 0 0" colours.pfm colours.pfm
says "0.0000e+00 0.0000 0.0000 inf 1.000000 0.0000e+00 0.000000 0 0" colours.pfm colours_big.pfm
says "0.0000e+00 0.0000 0.0000 inf 1.000000 0.0000e+00 0.000000 0 0" level_big.pfm level.pfm

# Every value off by one level, whose float is a hair above 1/255. Both pictures are flat: similarity is
# C1 / (1/255^2 + C1) with C1 = 1e-4, which is 0.866711.
says "3.9216e-03 1.0000 1.0000 48.131 0.866711 3.9216e-03 1.000000 0 0" level.pfm black.pfm
says "3.9216e-03 1.0000 1.0000 48.131 0.866711 3.9216e-03 1.000000 0 0" black.pfm level_big.pfm

# One pixel against its reference: errors 1/4, 0 and 1 in the three channels; sqrt((1/16 + 1) / 3), and of the similarities
# C1 / (1/16 + C1), 1 and C1 / (1 + C1) the mean.
pfm one.pfm 1 1 little $quarter $half $one
pfm other.pfm 1 1 big $zero $half $zero
says "5.9512e-01 255.0000 255.0000 4.508 0.333899 4.1667e-01 1.000000 0 0" one.pfm other.pfm

# The window: a point of 1 in a black row of 3. Along x the 11 taps of sigma 1.5 are w0 = 0.266012, w1 = 0.213006 (and so on);
# with the border repeated the weight of the middle pixel is w1, w0 and w1, and m = w, v = w - w^2 give
# C1 C2 / ((m^2 + C1) (v + C2)) around each.
# shellcheck disable=SC2046
{
    pfm point.pfm 3 1 little $(repeated 3 $zero) $(repeated 3 $one) $(repeated 3 $zero)
    pfm row.pfm 3 1 little $(repeated 9 $zero)
}
ssim=$(awk 'BEGIN {
    for (i = -5; i <= 5; ++i) { w[i] = exp(-i * i / 4.5); sum += w[i] }
    for (i = -1; i <= 1; ++i) { m = w[i] / sum; mean += 1e-4 * 9e-4 / ((m * m + 1e-4) * (m - m * m + 9e-4)) / 3 }
    printf "%.6f", mean }')
says "5.7735e-01 255.0000 255.0000 4.771 $ssim 3.3333e-01 0.333333 1 0" point.pfm row.pfm

# The point at the left end: what the window has beyond it is the point again.
# shellcheck disable=SC2046
pfm point.pfm 3 1 little $(repeated 3 $one) $(repeated 6 $zero)
ssim=$(awk 'BEGIN {
    for (i = -5; i <= 5; ++i) { w[i] = exp(-i * i / 4.5); sum += w[i] }
    for (x = 0; x <= 2; ++x) {
        m = 0
        for (i = -5; i <= -x; ++i) m += w[i] / sum
        mean += 1e-4 * 9e-4 / ((m * m + 1e-4) * (m - m * m + 9e-4)) / 3
    }
    printf "%.6f", mean }')
says "5.7735e-01 255.0000 255.0000 4.771 $ssim 3.3333e-01 0.333333 0 0" point.pfm row.pfm

# A point in a picture of 30 x 40, where a window holds it whole: 121 of the 1200 pixels see it.
# shellcheck disable=SC2046
{
    pfm point.pfm 30 40 little $(repeated 1830 $zero) $(repeated 3 $one) $(repeated 1767 $zero)
    pfm large.pfm 30 40 little $(repeated 3600 $zero)
}
ssim=$(awk 'BEGIN {
    for (i = -5; i <= 5; ++i) { w[i] = exp(-i * i / 4.5); sum += w[i] }
    for (i = -5; i <= 5; ++i) for (j = -5; j <= 5; ++j) {
        m = w[i] * w[j] / (sum * sum); mean += 1e-4 * 9e-4 / ((m * m + 1e-4) * (m - m * m + 9e-4)) }
    printf "%.6f", (mean + 1200 - 121) / 1200 }')
# 3 of 3600 values are off by 1: the 3597th smallest error (0.999 of them, 3596.4, rounded up) is 0.
says "2.8868e-02 255.0000 0.0000 30.792 $ssim 8.3333e-04 0.000833 10 19" point.pfm large.pfm

# A pixel is off whatever channel is; off by a hair less than a level it is not.
under=3b808080
pfm black_1.pfm 1 1 little $zero $zero $zero
for case in "1.000000 $level $zero $zero" "1.000000 $zero $level $zero" "1.000000 $under $under $level" \
    "0.000000 $under $under $under"; do
    # shellcheck disable=SC2086
    set -- $case
    pfm channel.pfm 1 1 big "$2" "$3" "$4"
    share=$("$program" channel.pfm black_1.pfm | sed -n 's/^share_over_one_level //p')
    [ "$share" = "$1" ] || fail "the share of $case is $share"
done

# The rank: of 1002 values it is the 1001st, the first of the two that are off, and of 999 the last.
# shellcheck disable=SC2046
{
    pfm black.334.pfm 334 1 little $(repeated 1002 $zero)
    pfm two.pfm 334 1 little $(repeated 1000 $zero) $half $one
    pfm one_off.pfm 334 1 little $(repeated 1001 $zero) $one
    pfm black.333.pfm 333 1 little $(repeated 999 $zero)
    pfm last.pfm 333 1 little $one $(repeated 998 $zero)
}
for case in "two.pfm black.334.pfm 127.5000" "one_off.pfm black.334.pfm 0.0000" "last.pfm black.333.pfm 255.0000"; do
    # shellcheck disable=SC2086
    set -- $case
    p999=$("$program" "$1" "$2" | sed -n 's/^p999_levels //p')
    [ "$p999" = "$3" ] || fail "p999 of $1 is $p999, not $3"
done

# The largest error's pixel, from the top left. Of two equal ones it is the first as people read, which is the last row of the file.
# shellcheck disable=SC2046
{
    pfm dark.pfm 2 3 little $(repeated 18 $zero)
    pfm two_rows.pfm 2 3 big $(repeated 5 $zero) $one $(repeated 8 $zero) $one $(repeated 3 $zero)
    pfm negative.pfm 2 3 big $(repeated 7 $zero) $minus $half $(repeated 9 $zero)
}
for case in "two_rows.pfm 0 0" "negative.pfm 0 1"; do
    # shellcheck disable=SC2086
    set -- $case
    pixel=$("$program" "$1" dark.pfm | sed -n 's/^max_[xy] //p' | tr '\n' ' ')
    [ "$pixel" = "$2 $3 " ] || fail "the largest error of $1 is at $pixel, not $2 $3"
done

# --- CSV ---------------------------------------------------------------------------------------
for arguments in "--csv one.pfm other.pfm" "one.pfm other.pfm --csv"; do
    # shellcheck disable=SC2086
    "$program" $arguments >stdout || fail "status $? with $arguments"
    printf '%s\n%s\n' "$(echo "$names" | tr ' ' ',')" 5.9512e-01,255.0000,255.0000,4.508,0.333899,4.1667e-01,1.000000,0,0 >expected
    cmp -s stdout expected || fail "$arguments: $(cat stdout)"
done

# --- what is refused ---------------------------------------------------------------------------
"$program" --help >stdout 2>stderr || fail "status $? with --help"
[ ! -s stderr ] || fail "--help writes on standard error"
for name in $names --csv --help; do grep -qE -e "^  (max_x, )?$name[, ]" stdout || fail "$name is not in the help"; done

refuses "0 files are named"
refuses "1 file is named" one.pfm
refuses "3 files are named" one.pfm one.pfm one.pfm
refuses "no option --digits" --digits 3 one.pfm one.pfm
refuses "no option -x" -x
refuses "absent.pfm (No such file" one.pfm absent.pfm
refuses "absent.pfm (No such file" absent.pfm one.pfm
refuses "directory" . one.pfm
refuses "absent?line.pfm" "absent
line.pfm" one.pfm
refuses "level.pfm with one.pfm (4 x 3 pixels against 1 x 1)" level.pfm one.pfm

: >empty.pfm
printf 'P6\n1 1\n255\nabc' >other.ppm
printf 'Pf\n1 1\n-1.0\nabcd' >grey.pfm
printf 'PF' >head_1.pfm
printf 'PF\n1' >head_2.pfm
printf 'PF\n1 1\n' >head_3.pfm
printf 'PF\n1 1\n-1.0' >head_4.pfm
printf 'PF\n1 x\n-1.0\nabcdabcdabcd' >head_5.pfm
printf 'PF\n1 1\nnear\nabcdabcdabcd' >head_6.pfm
refuses "does not begin with" one.pfm empty.pfm
refuses "does not begin with" other.ppm one.pfm
refuses "a grey PFM" grey.pfm one.pfm
for i in 1 2 3 4 5 6; do refuses "its header is not" head_$i.pfm one.pfm; done

resized() { # FILE WIDTH HEIGHT SCALE BYTES: one.pfm's first bytes under another header
    printf 'PF\n%s %s\n%s\n' "$2" "$3" "$4" >"$1"
    tail -c 12 one.pfm | head -c "$5" >>"$1"
}
resized same.pfm 1 1 -1 12
says "0.0000e+00 0.0000 0.0000 inf 1.000000 0.0000e+00 0.000000 0 0" one.pfm same.pfm
for bytes in 0 4 11; do
    resized short.pfm 1 1 -1.0 $bytes
    refuses "it ends after $bytes bytes of the pixels of 1 x 1" one.pfm short.pfm
done
resized claims.pfm 2147483647 2147483647 -1.0 12
refuses "it ends after 12 bytes" claims.pfm one.pfm
cat one.pfm >long.pfm && printf 'a' >>long.pfm
refuses "it goes on after its 1 x 1 pixels" long.pfm one.pfm
for size in "0 1" "1 0" "2147483648 1"; do
    # shellcheck disable=SC2086
    resized size.pfm $size -1.0 12
    refuses "its \(width\|height\) is" size.pfm one.pfm
done
for size in "-1 1" "99999999999 1" "1.5 1"; do
    # shellcheck disable=SC2086
    resized size.pfm $size -1.0 12
    refuses "its header is not" size.pfm one.pfm
done
for scale in 0 2 -0.5; do
    resized scale.pfm 1 1 $scale 12
    refuses "its scale is $scale" scale.pfm one.pfm
done

# Files have the bottom row first, people count from the top: the last pixel of the file is in row 0.
pfm not_finite.pfm 1 2 little $zero $zero $zero $zero $nan $zero
pfm infinite.pfm 1 2 big $zero $zero $infinity $zero $zero $zero
pfm finite.pfm 1 2 little $zero $zero $zero $zero $zero $zero
refuses "not_finite.pfm (its pixel 0, 0 is not finite in channel 1)" not_finite.pfm finite.pfm
refuses "infinite.pfm (its pixel 0, 1 is not finite in channel 2)" finite.pfm infinite.pfm

if [ -w /dev/full ]; then
    status=0
    "$program" one.pfm other.pfm >/dev/full 2>stderr || status=$?
    [ $status -eq 2 ] || fail "status $status, not 2, where nothing can be written"
    grep -q '^cannot write the measures (.*); .' stderr || fail "a full device: $(cat stderr)"
fi

[ $failures -eq 0 ] || { echo "$failures failures"; exit 1; }
echo "pfm_error: all good"
