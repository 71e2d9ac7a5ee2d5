#!/usr/bin/env python3
"""initramfs.py OUT KERNEL_VERSION MODULE_ROOT BUSYBOX INIT MODULE...

Writes the smallest initramfs that can mount the guest's root over 9p: busybox, an init script, the named modules with
what they depend on, and the order in which to load them (format: newc cpio).
"""
import lzma
import os
import sys


class Archive:
    def __init__(self):
        self.bytes, self.inode = bytearray(), 0

    def add(self, name, mode, data=b"", device=(0, 0)):
        self.inode += 1
        raw = name.encode() + b"\0"
        fields = (self.inode, mode, 0, 0, 1, 0, len(data), 0, 0, *device, len(raw), 0)
        entry = b"070701" + b"".join(b"%08X" % field for field in fields) + raw
        entry += b"\0" * (-len(entry) % 4) + data
        self.bytes += entry + b"\0" * (-len(entry) % 4)


def module_name(path):
    return os.path.basename(path).split(".")[0].replace("-", "_")


def load_order(base, wanted):
    with open(f"{base}/modules.dep") as file:
        needs = {module_name(path): (path, rest.split()) for path, _, rest in (line.partition(":") for line in file)}
    order = []
    for module in wanted:
        if module.replace("-", "_") not in needs:  # built in
            continue
        path, before = needs[module.replace("-", "_")]
        order += [each for each in [*reversed(before), path] if each not in order]
    return order


def main(out, version, root, busybox, init, *modules):
    base = f"{root}/lib/modules/{version}"
    archive = Archive()
    for folder in ("dev", "proc", "sys", "newroot", "bin", "mods"):
        archive.add(folder, 0o40755)
    archive.add("dev/console", 0o20600, device=(5, 1))
    for name, path in (("bin/busybox", busybox), ("init", init)):
        with open(path, "rb") as file:
            archive.add(name, 0o100755, file.read())
    order = load_order(base, modules)
    for path in order:
        with open(f"{base}/{path}", "rb") as file:
            data = file.read()
        archive.add("mods/" + os.path.basename(path), 0o100644, lzma.decompress(data) if path.endswith(".xz") else data)
    archive.add("mods/order", 0o100644, "".join(os.path.basename(path) + "\n" for path in order).encode())
    archive.add("TRAILER!!!", 0)
    with open(out, "wb") as file:
        file.write(archive.bytes)


if __name__ == "__main__":
    if len(sys.argv) < 6:
        sys.exit(__doc__)
    main(*sys.argv[1:])
