# A Debian 12 that has nothing but the package hdrcam, in a folder of its own. Sourced; needs root, debootstrap and
# a Debian mirror. Gives $root, inside COMMAND.. (in that Debian) and say; the folder goes when the script ends.
#   make_clean_root FOLDER_OF_PACKAGES MIRROR MORE_PACKAGES..: MIRROR may be empty, MORE_PACKAGES are Debian's
say() { printf '== %s\n' "$*"; }
inside() { chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive "$@"; }

remove_clean_root() {
  umount "$root/proc" 2>/dev/null || true
  rm -rf --one-file-system "$root"
}

make_clean_root() {
  local packages mirror=$2
  packages=$(realpath "$1")
  shift 2
  mirror=${mirror:-$({ cat /etc/apt/sources.list /etc/apt/sources.list.d/debian.sources 2>/dev/null || true; } |
    sed -n 's/^URIs: *//p; s/^deb \(http[^ ]*\) .*/\1/p' | head -n 1)}
  [ -n "$mirror" ] || { say "no mirror of Debian in /etc/apt; give one" >&2; exit 1; }
  root=$(mktemp -d /var/tmp/hdrcam-clean.XXXXXX)
  chmod 755 "$root" # the service's user must reach the libraries
  trap remove_clean_root EXIT

  say "debootstrap bookworm from $mirror"
  debootstrap --variant=minbase bookworm "$root" "$mirror" >"$root.log" 2>&1 || { tail "$root.log"; rm -f "$root.log"; exit 1; }
  rm -f "$root.log"
  printf 'deb %s bookworm main\ndeb %s bookworm-updates main\n' "$mirror" "$mirror" >"$root/etc/apt/sources.list"
  cp -r /etc/apt/apt.conf.d/. "$root/etc/apt/apt.conf.d/" # a proxy, where there is one
  mount -t proc proc "$root/proc"
  mkdir "$root/work"
  cp "$packages"/*.deb "$root/work/"
  inside apt-get update -qq

  say "install hdrcam${*:+, $*}"
  inside sh -c "apt-get install -qq -y --no-install-recommends /work/hdrcam_*.deb $* >/dev/null"
  inside hdrcam --version
}
