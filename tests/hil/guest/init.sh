#!/bin/busybox sh
# First process of the guest: mounts the Debian root over 9p and goes on there.
B=/bin/busybox
$B mount -t proc proc /proc
$B mount -t sysfs sys /sys
$B mount -t devtmpfs dev /dev
for module in $($B cat /mods/order); do $B insmod /mods/$module || echo "HIL-FAIL insmod $module"; done
share=trans=virtio,version=9p2000.L,msize=262144
$B mount -t 9p -o ro,cache=loose,$share root /newroot || { echo "HIL-FAIL mount the root"; $B poweroff -f; }
for folder in proc sys dev; do $B mount --move /$folder /newroot/$folder; done
$B mount -t tmpfs tmpfs /newroot/run
$B mount -t tmpfs tmpfs /newroot/tmp
$B mount -t 9p -o ro,cache=loose,$share mods /newroot/lib/modules
$B mount -t 9p -o rw,$share hil /newroot/hil
exec $B switch_root /newroot /bin/busybox sh /hil/guest.sh
