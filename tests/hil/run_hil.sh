#!/bin/bash
# The kernel test bed: boots Debian 12's own kernel in qemu with a virtual sensor (vimc), a virtual camera (vivid), GPIO lines
# (gpio-sim) and USB cameras simulated in user space, and runs a program inside. Nothing is simulated above the kernel's
# interfaces, and no KVM, root or hardware is needed.
#
#   tests/hil/run_hil.sh BUILD [ARGUMENT...]              hdrcam_hil of that build folder, with Catch2's arguments
#   HIL_PROGRAM='PROGRAM ARGUMENT...' tests/hil/run_hil.sh BUILD    another program, in the folder with the binaries
#
# exit: 0 passed, 1 failed, 2 could not set up, 124 took too long (HIL_TIMEOUT seconds, 900).
# needs: apt with Debian 12's lists, g++, make, xz, python3. Packages are unpacked under HIL_CACHE (build/hil), never installed;
# the first run fetches 320 MB and takes a minute more.
set -eu
export LC_ALL=C
here=$(cd "$(dirname "$0")" && pwd)
[ $# -ge 1 ] || { sed -n '2,12s/^# \{0,1\}//p' "$0"; exit 2; }
build=$(cd "$1" && pwd); shift
cache=${HIL_CACHE:-$here/../../build/hil}
mkdir -p "$cache" && cache=$(cd "$cache" && pwd)
cd "$cache"
mkdir -p host guest kernel build share
: > no-packages

started=$(date +%s)
say() { printf '%4d s  %s\n' $(($(date +%s) - started)) "$*"; }
setup_failed() { echo "hil: $*" >&2; exit 2; }

# shellcheck source=tests/unpacked_packages.sh
. "$here/../unpacked_packages.sh"

# What kernel modules are built with: packages_of_build RELEASE VERSION
packages_of_build() {
  local package
  for package in "linux-headers-$1" "linux-headers-${1%-amd64}-common" linux-kbuild-6.1 linux-compiler-gcc-12-x86 linux-source-6.1; do
    echo "$package=$2"
  done
}

# Release and version of the newest kernel of which apt has everything: while Debian publishes an update, the image that
# linux-image-amd64 names can be older than all that is left to build modules with.
newest_kernel() {
  local release version
  for release in $(apt-cache "${apt_options[@]}" pkgnames linux-image-6.1.0- | grep -E '^linux-image-6\.1\.0-[0-9]+-amd64$' | sort -rV); do
    release=${release#linux-image-}
    version=$(apt-cache "${apt_options[@]}" policy "linux-image-$release" | awk '/Candidate/{print $2}')
    # shellcheck disable=SC2046 # one package a word
    ! apt-get "${apt_options[@]}" -qq --print-uris download $(packages_of_build "$release" "$version") > /dev/null 2>&1 ||
      { echo "$release $version"; return; }
  done
}

fetch() {
  packages_in "$cache"
  local version release
  read -r release version <<< "$(newest_kernel)"
  [ -n "$version" ] || setup_failed "apt knows no kernel 6.1 with its headers and source of one version"
  echo "$release" > release
  download packages/kernel "linux-image-$release=$version"
  # shellcheck disable=SC2046 # one package a word
  download packages/build $(packages_of_build "$release" "$version")
  command -v qemu-system-x86_64 > /dev/null || download_closure packages/host "" qemu-system-x86
  download_closure packages/guest "$cache/no-packages" busybox-static kmod udev libcamera-ipa libgpiod2
  say "fetched $(du -shc packages | awk 'END{print $1}') for kernel $release"
  unpack packages/kernel kernel
  unpack packages/build build
  unpack packages/guest guest
  [ ! -d packages/host ] || unpack packages/host host
  mkdir -p guest/{proc,sys,dev,run,tmp,hil,root,lib/modules}
  touch fetched
  say unpacked
}

# Debian's kernel lacks vimc and gpio-sim; they are built from its own source.
build_modules() {
  local place=$cache source=linux-source-6.1 module
  if [[ $cache =~ [[:space:]] ]]; then # make knows no path with a blank
    place=$(mktemp -d /tmp/hil.XXXXXX)
    # shellcheck disable=SC2064 # the place that it is now
    trap "rm -rf '$place'" EXIT
    cp -r build "$place/"
  fi
  local headers=$place/build/usr/src/linux-headers-$release modules=$place/modules
  sed -i "s#^include .*/usr/src#include $place/build/usr/src#" "$headers/Makefile"
  tar -xJf build/usr/src/$source.tar.xz --wildcards "$source/drivers/media/test-drivers/vimc/*" "$source/drivers/gpio/*" \
    "$source/kernel/irq/irq_sim.c"
  rm -rf "$modules"
  mkdir -p "$modules"/{vimc,gpio-sim,hilfw}
  cp $source/drivers/media/test-drivers/vimc/* "$modules/vimc/"
  sed -i 's/\$(CONFIG_VIDEO_VIMC)/m/' "$modules/vimc/Makefile"
  python3 "$here/modules/patch_vimc.py" "$modules/vimc/vimc-sensor.c"
  # gpio-sim needs the kernel's irq_sim, which Debian leaves out: one module of both.
  cp $source/drivers/gpio/*.h "$modules/gpio-sim/"
  cp $source/drivers/gpio/gpio-sim.c "$modules/gpio-sim/gpio_sim.c"
  sed 's/handle_simple_irq(irq_to_desc(irqnum))/generic_handle_irq(irqnum)/' $source/kernel/irq/irq_sim.c > "$modules/gpio-sim/irq_sim.c"
  printf 'obj-m := gpio-sim.o\ngpio-sim-y := gpio_sim.o irq_sim.o\n' > "$modules/gpio-sim/Makefile"
  cp "$here/modules/hilfw.c" "$modules/hilfw/"
  echo 'obj-m := hilfw.o' > "$modules/hilfw/Makefile"
  mkdir -p "$tree/extra"
  for module in vimc gpio-sim hilfw; do
    make -C "$headers" M="$modules/$module" modules > "$module.log" 2>&1 ||
      { tail "$module.log"; setup_failed "the kernel module $module does not build"; }
    strip -g -o "$tree/extra/$module.ko" "$modules/$module/$module.ko"
  done
  local libraries=guest/lib/x86_64-linux-gnu:guest/usr/lib/x86_64-linux-gnu
  guest/lib64/ld-linux-x86-64.so.2 --argv0 depmod --library-path $libraries guest/bin/kmod -b "$cache/kernel" "$release"
  python3 "$here/guest/initramfs.py" initramfs "$release" kernel guest/bin/busybox "$here/guest/init.sh" \
    virtio_pci 9pnet_virtio 9p
  touch built
  say "built the kernel modules"
}

# The binaries with every library that they name, so that they run in a root that has none of them.
share_program() {
  rm -rf share && mkdir -p share/lib
  cp "$here/guest/guest.sh" share/
  local binary
  for binary in hdrcam_hil hdrcam_usb_camera hdrcam; do
    binary=$(find "$build" -maxdepth 3 -name $binary -type f -perm -u+x | head -1)
    [ -n "$binary" ] || continue
    cp "$binary" share/
    ldd "$binary" | awk '/=> \//{print $3}' | xargs -r -I{} cp -uL {} share/lib/
  done
  # The C library and libcamera (whose plug-ins are signed for it) are the guest's.
  rm -f share/lib/{libc,libm,libpthread,libdl,librt}.so.* share/lib/libcamera*.so.*
  {
    echo 'cd /hil; export LD_LIBRARY_PATH=/hil/lib'
    if [ -n "${HIL_PROGRAM:-}" ]; then echo "$HIL_PROGRAM"; else printf './hdrcam_hil --durations yes'; printf ' %q' "$@"; echo; fi
  } > share/command.sh
}

boot() {
  local qemu firmware=() libraries=""
  qemu=$(command -v qemu-system-x86_64 || true)
  if [ -z "$qemu" ]; then
    qemu=host/usr/bin/qemu-system-x86_64
    firmware=(-L host/usr/share/qemu -L host/usr/share/seabios -L host/usr/lib/ipxe/qemu)
    libraries=$cache/host/usr/lib/x86_64-linux-gnu:$cache/host/lib/x86_64-linux-gnu
  fi
  local shares=() tag
  for tag in root=guest,readonly=on mods=kernel/lib/modules,readonly=on hil=share; do
    shares+=(-fsdev "local,id=${tag%%=*},security_model=none,path=$cache/${tag#*=}"
      -device "virtio-9p-pci,fsdev=${tag%%=*},mount_tag=${tag%%=*}")
  done
  # One processor: emulating two takes longer. In the foreground, where ^C reaches it.
  LD_LIBRARY_PATH=$libraries timeout --foreground "${HIL_TIMEOUT:-900}" "$qemu" "${firmware[@]}" -M q35 -accel tcg -cpu max -m 1024 \
    -display none -no-reboot -nodefaults -serial file:serial.txt "${shares[@]}" -kernel kernel/boot/vmlinuz-"$release" \
    -initrd initramfs -append "console=ttyS0 panic=-1 quiet" < /dev/null
}

[ -e fetched ] || fetch
release=$(cat release)
tree=kernel/lib/modules/$release
[ -e built ] || build_modules
share_program "$@"
rm -f serial.txt
status=0
boot || status=$?
[ ! -e share/out.txt ] || cat share/out.txt
tr -d '\r' < serial.txt | grep -a '^HIL-' || true
say "qemu ended with $status"
[ $status != 124 ] || exit 124
grep -aq '^HIL-FAIL' serial.txt && exit 2
grep -aq '^HIL-END rc=0' serial.txt
