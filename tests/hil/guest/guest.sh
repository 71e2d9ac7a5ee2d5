# In the guest's Debian root: brings the devices up, runs the tests, says how it went, switches off.
export PATH=/usr/sbin:/usr/bin:/sbin:/bin
bb=/bin/busybox
uptime() { $bb cut -d' ' -f1 /proc/uptime; }
echo "HIL-BOOT $($bb uname -r), $(uptime) s"
/lib/systemd/systemd-udevd --daemon 2> /dev/null
udevadm trigger && udevadm settle

modprobe vimc && modprobe vivid n_devs=2 node_types=0x1,0x1 multiplanar=1,2 && modprobe vhci-hcd && modprobe hilfw &&
  modprobe uvcvideo && modprobe gpio-sim || echo "HIL-FAIL modprobe"
$bb mount -t configfs none /sys/kernel/config
chip=/sys/kernel/config/gpio-sim/cam
$bb mkdir -p $chip/bank0/line0 $chip/bank0/line1 $chip/bank0/line2/hog
echo 8 > $chip/bank0/num_lines
echo camsync > $chip/bank0/label
echo FSYNC > $chip/bank0/line0/name
echo STROBE > $chip/bank0/line1/name
echo HELD > $chip/bank0/line2/name
echo pwm-fan > $chip/bank0/line2/hog/name
echo output-low > $chip/bank0/line2/hog/direction
echo 1 > $chip/live
udevadm settle
echo "HIL-READY $(uptime) s"

export HIL_GPIO=/sys/devices/platform/$($bb cat $chip/dev_name)/$($bb cat $chip/bank0/chip_name)
$bb timeout ${HIL_LIMIT:-870} /bin/busybox sh /hil/command.sh > /hil/out.txt 2>&1
echo "HIL-END rc=$? $(uptime) s"
$bb sync
$bb poweroff -f
