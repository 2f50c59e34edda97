#!/bin/bash
# usage: bare_debian.sh [--packages-only] [FOLDER]
# The README's two commands, as printed there, on a Debian 12 that has nothing but apt: a chroot below FOLDER (default: /tmp), which
# is removed at the end. Takes the committed state of the repository. Prints the seconds of each command; fails where one fails or a
# test does. With --packages-only each command ends after its packages and `cmake --version`.
# Needs root, debootstrap, 3 GB of disk, and with the tests about half an hour on two cores. DEBIAN_MIRROR names the mirror; default:
# the one that this machine takes its own packages from.
set -euo pipefail
export LC_ALL=C
repository=$(cd "$(dirname "$0")/../.." && pwd)
packages_only=no
if [ "${1:-}" = --packages-only ]; then
    packages_only=yes
    shift
fi
root=$(mktemp -d "${1:-/tmp}/bare_debian.XXXXXX")
trap 'rm -rf --one-file-system "$root"' EXIT
chmod 755 "$root" # apt reads in it as its own user
trap 'exit 130' INT TERM

# A command stands in a block, where one that ends with && goes on in the next line, or between backticks in a sentence.
mapfile -t commands < <(awk '/^```/ { inside = /^```sh/; line = ""; next } inside { line = line $0 } /&&$/ { next }
    inside && line ~ /cmake --workflow/ { gsub(/ +/, " ", line); print line }
    !inside && match($0, /`cmake --workflow [^`]*`/) { print substr($0, RSTART + 1, RLENGTH - 2) }
    { line = "" }' "$repository/README.md")
if [ ${#commands[@]} -ne 2 ]; then
    echo "README.md has ${#commands[@]} commands with \`cmake --workflow\` (two are expected); correct one of us" >&2
    exit 2
fi

mirror=${DEBIAN_MIRROR:-$(apt-get indextargets --format '$(REPO_URI)' 'Codename: bookworm' 'Label: Debian' 2>/dev/null | head -n 1 || true)}
mirror=${mirror:-http://deb.debian.org/debian}
echo "== Debian 12 from $mirror"
debootstrap --variant=minbase bookworm "$root" "$mirror" >"$root.log" 2>&1 || { tail "$root.log"; rm -f "$root.log"; exit 1; }
rm -f "$root.log"

# How this machine reaches the network.
cp -L /etc/resolv.conf "$root/etc/resolv.conf"
for file in /etc/apt/apt.conf /etc/apt/apt.conf.d/*; do
    if grep -qsiE 'proxy|verify-peer|cainfo' "$file"; then cp "$file" "$root/etc/apt/apt.conf.d/"; fi
done
if [ -e /etc/ssl/certs/ca-certificates.crt ]; then
    mkdir -p "$root/etc/ssl/certs"
    cp -L /etc/ssl/certs/ca-certificates.crt "$root/etc/ssl/certs/"
fi

# In the chroot one is root and has no sudo.
printf '#!/bin/sh\nexec "$@"\n' >"$root/usr/local/bin/sudo"
chmod +x "$root/usr/local/bin/sudo"
mkdir "$root/tilemesh"
git -C "$repository" archive HEAD | tar -x -C "$root/tilemesh"

# A shell command in the chroot, in a bare environment; what it mounts and starts ends with it.
environment=(HOME=/ PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8
    DEBIAN_FRONTEND=noninteractive)
for name in http_proxy https_proxy no_proxy; do
    if [ -n "${!name:-}" ]; then environment+=("$name=${!name}"); fi
done
inside() {
    env -i "${environment[@]}" unshare --mount --pid --fork --kill-child \
        sh -c 'mount -t proc proc "$1/proc" && mount -t devpts devpts "$1/dev/pts" && exec chroot "$1" sh -c "cd /tilemesh && $2"' sh "$root" "$1"
}

inside 'apt-get update -q'
for command in "${commands[@]}"; do
    if [ $packages_only = yes ]; then command="${command%%cmake --workflow*}cmake --version"; fi
    printf '\n== %s\n' "$command"
    begin=$SECONDS
    inside "$command" 2>&1 | tee "$root/log"
    echo "== $((SECONDS - begin)) s"
    if grep -E '[1-9][0-9]* tests failed' "$root/log"; then exit 1; fi
done
