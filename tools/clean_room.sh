#!/bin/sh
# Proves on a bare Debian 12 that the two commands of the README do all of the set-up.
#
#   sudo tools/clean_room.sh ROOM [COMMAND...]
#
# ROOM is a folder of its own (8 GB free): ROOM/base is made once by debootstrap, ROOM/root
# is copied from it anew every time. The committed tree (HEAD) is unpacked in the new root
# and each COMMAND is run there by sh; without any: 'make test' and 'make demo'.
#
# Environment, all optional:
#   MIRROR   Debian mirror, default http://deb.debian.org/debian
#   COPY     files and folders of this machine to lay at the same place in the root, e.g.
#            "/etc/pip.conf /etc/ssl/certs/ca-certificates.crt" behind a package mirror
# Variables that begin with PIP_ or SSL_CERT_, and the proxies, are handed on as they are.
set -eu

[ $# -ge 1 ] || { sed -n '2,15s/^# \{0,1\}//p' "$0" >&2; exit 2; }
[ "$(id -u)" -eq 0 ] || { echo "clean_room: chroot needs root: sudo $0 $*" >&2; exit 2; }
command -v debootstrap >/dev/null || { echo "clean_room: apt-get install debootstrap" >&2; exit 2; }

tree=$(cd "$(dirname "$0")/.." && pwd)
mkdir -p "$1"
room=$(cd "$1" && pwd)
shift
[ $# -ge 1 ] || set -- 'make test' 'make demo'

make_base() {
    [ -e "$room/base/.complete" ] && return
    rm -rf "$room/base"
    debootstrap --variant=minbase --include=python3,python3-venv,make,ca-certificates \
        bookworm "$room/base" "${MIRROR:-http://deb.debian.org/debian}" >"$room/debootstrap.log" ||
        { tail -n 5 "$room/debootstrap.log" >&2; exit 1; }
    touch "$room/base/.complete"
}

make_root() {
    rm -rf --one-file-system "$room/system"
    cp -a "$room/base" "$room/system"
    cp -L /etc/resolv.conf "$room/system/etc/resolv.conf"
    for item in ${COPY:-}; do
        mkdir -p "$room/system$(dirname "$item")"
        cp -aL "$item" "$room/system$(dirname "$item")/"
    done
    mkdir "$room/system/shapemorph"
    git -C "$tree" archive HEAD | tar -x -C "$room/system/shapemorph"
}

# /proc is mounted in a mount namespace of its own, so nothing stays mounted afterwards.
enter() {
    kept=$(env | sed -n -E 's/^((PIP|SSL_CERT)_[A-Z_]*|https?_proxy|no_proxy)=.*/\1/p')
    set -- "$1" HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8
    command=$1
    shift
    for name in $kept; do eval "set -- \"\$@\" \"\$name=\${$name}\""; done
    unshare --mount sh -c '
        mount -t proc proc "$1/proc" && mount --bind /dev "$1/dev"
        root=$1 command=$2
        shift 2
        exec env -i "$@" chroot "$root" sh -c "cd /shapemorph && $command"
    ' enter "$room/system" "$command" "$@"
}

make_base
make_root
echo "clean_room: $(git -C "$tree" log -1 --format='%h %s')"
for command in "$@"; do
    echo "clean_room: $command"
    start=$(date +%s)
    enter "$command" || { echo "clean_room: FAILED: $command" >&2; exit 1; }
    echo "clean_room: '$command' took $(($(date +%s) - start)) s"
done
