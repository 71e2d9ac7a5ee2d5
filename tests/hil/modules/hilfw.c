// SPDX-License-Identifier: GPL-2.0
/*
 * libcamera names a USB camera after the firmware node above its host controller. A virtual host controller has none;
 * this gives vhci_hcd.0 a "firmware_node/path" attribute.
 */
#include <linux/module.h>
#include <linux/platform_device.h>
#include <linux/sysfs.h>

static struct device *controller;

static ssize_t path_show(struct device *device, struct device_attribute *attribute, char *text)
{
	return sysfs_emit(text, "\\_SB_.HIL0\n");
}
static DEVICE_ATTR_RO(path);

static struct attribute *attributes[] = { &dev_attr_path.attr, NULL };
static const struct attribute_group group = { .name = "firmware_node", .attrs = attributes };

static int __init hilfw_init(void)
{
	int result;

	controller = bus_find_device_by_name(&platform_bus_type, NULL, "vhci_hcd.0");
	if (!controller)
		return -ENODEV;
	result = sysfs_create_group(&controller->kobj, &group);
	if (result)
		put_device(controller);
	return result;
}

static void __exit hilfw_exit(void)
{
	sysfs_remove_group(&controller->kobj, &group);
	put_device(controller);
}

module_init(hilfw_init);
module_exit(hilfw_exit);
MODULE_LICENSE("GPL");
MODULE_DESCRIPTION("test fixture: a firmware node for the virtual USB host controller");
