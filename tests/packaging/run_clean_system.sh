#!/usr/bin/env bash
# The packages in a Debian 12 that has nothing else: install, record, replay, a library user, purge. Needs root,
# debootstrap and a Debian mirror. Called by ./run installed clean-system.
#   run_clean_system.sh FOLDER_OF_PACKAGES [MIRROR]
set -euo pipefail
packages=$(realpath "$1")
mirror=${2:-$({ cat /etc/apt/sources.list /etc/apt/sources.list.d/debian.sources 2>/dev/null || true; } |
  sed -n 's/^URIs: *//p; s/^deb \(http[^ ]*\) .*/\1/p' | head -n 1)}
mirror=${mirror:-http://deb.debian.org/debian}
repository=$PWD
root=$(mktemp -d /var/tmp/hdrcam-clean.XXXXXX)
chmod 755 "$root" # the service's user must reach the libraries
leave() {
  umount "$root/proc" 2>/dev/null || true
  rm -rf --one-file-system "$root"
}
trap leave EXIT
inside() { chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive "$@"; }
say() { printf '== %s\n' "$*"; }

say "debootstrap bookworm from $mirror"
debootstrap --variant=minbase bookworm "$root" "$mirror" >"$root.log" 2>&1 || { tail "$root.log"; exit 1; }
rm -f "$root.log"
printf 'deb %s bookworm main\ndeb %s bookworm-updates main\n' "$mirror" "$mirror" >"$root/etc/apt/sources.list"
cp -r /etc/apt/apt.conf.d/. "$root/etc/apt/apt.conf.d/" # a proxy, where there is one
mount -t proc proc "$root/proc"
mkdir "$root/work"
cp "$packages"/*.deb "$repository/tests/data/demo.mkv" "$root/work/"
inside apt-get update -qq

say "install hdrcam"
inside sh -c 'apt-get install -qq -y --no-install-recommends /work/hdrcam_*.deb >/dev/null'
inside hdrcam --version
inside id hdrcam
say "replay"
inside hdrcam replay /work/demo.mkv -o /work/out/%06d.exr 2>/dev/null
[ "$(find "$root/work/out" -name '*.exr' | wc -l)" = 24 ]
say "record from the simulator, as the service's user"
inside install -d -o hdrcam -g hdrcam /var/lib/hdrcam
inside setpriv --reuid hdrcam --regid hdrcam --init-groups hdrcam record --camera sim:walk --frames 30 -o /var/lib/hdrcam/walk.mkv
inside hdrcam info /var/lib/hdrcam/walk.mkv | grep 'frames  *30'

say "install hdrcam-dev and a compiler; compile the example"
inside sh -c 'apt-get install -qq -y --no-install-recommends g++ cmake make pkg-config /work/hdrcam-dev_*.deb >/dev/null'
inside sh -c 'cmake -S /usr/share/doc/hdrcam-dev/examples/mean_radiance -B /work/example >/dev/null &&
  cmake --build /work/example >/dev/null && /work/example/mean_radiance /work/demo.mkv | tail -1'

say "purge"
inside sh -c 'apt-get purge -qq -y hdrcam hdrcam-dev >/dev/null'
after=$(inside find /usr /etc /var/lib -xdev -name '*hdrcam*' ! -path '/var/lib/hdrcam*' | sort)
[ -z "$after" ] || { printf 'left behind:\n%s\n' "$after"; exit 1; }
[ -e "$root/var/lib/hdrcam/walk.mkv" ] && echo "nothing is left but the recording"
