#!/bin/sh
# bare_system.sh SUITE [COMMAND...]     (as root; needs debootstrap)
#
# Clones this checkout's last commit into a minimal Debian root that holds nothing but git, make and python3, and runs
# the commands there, one after the other (default: "make demo" "make test"). The root is made on first use under
# $BARE_ROOTS (default build/roots) and kept; delete it for a fresh one. $BARE_MIRROR: where debootstrap finds
# Debian (default: its own choice). $BARE_PREPARE: a program told the root's path before the commands run, for what
# this network needs (a proxy, a certificate, a cache of packages).
set -eu
cd "$(dirname "$0")/.."
suite=$1
shift
[ $# -gt 0 ] || set -- "make demo" "make test"
roots=${BARE_ROOTS:-build/roots}
mkdir -p "$roots"
root=$(realpath "$roots")/$suite

if [ ! -e "$root.made" ]; then
  debootstrap --variant=minbase --include=git,make,python3 "$suite" "$root" ${BARE_MIRROR:+"$BARE_MIRROR"}
  touch "$root.made"
fi
rm -rf "$root/root/adc-bench"
git clone -q --no-hardlinks . "$root/root/adc-bench"
git -C "$root/root/adc-bench" log -1 --format='bare system: commit %h'

# a mount namespace of its own: nothing stays mounted behind
exec unshare --mount sh -eu -c '
  root=$1 prepare=$2
  shift 2
  mount --bind "$root" "$root"  # a sandbox inside needs a root that is a mount of its own
  mount -t proc proc "$root/proc"
  mount --rbind /dev "$root/dev"
  mount -t tmpfs tmpfs "$root/tmp"
  cp /etc/resolv.conf "$root/etc/resolv.conf"
  [ -z "$prepare" ] || "$prepare" "$root"
  for command in "$@"; do
    started=$(date +%s)
    echo "bare system: $command"
    env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 \
      chroot "$root" sh -c "cd /root/adc-bench && $command"
    echo "bare system: $command: exit 0 after $(($(date +%s) - started)) s"
  done
' bare-system "$root" "${BARE_PREPARE:-}" "$@"
