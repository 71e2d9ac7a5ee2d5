"""Reads the half channels of an OpenEXR file of scan lines, ZIP or uncompressed, with the standard library alone: a second
reader, so that the program's files are not checked by the program."""
import struct
import zlib

NONE, ZIPS, ZIP = 0, 2, 3
LINES_OF_BLOCK = {NONE: 1, ZIPS: 1, ZIP: 16}
HALF = 1
BYTES_OF_TYPE = {0: 4, HALF: 2, 2: 4}  # unsigned, half, float


def header_of(data):
    """Attributes by name, and where the line table begins."""
    magic, version = struct.unpack_from('<II', data, 0)
    assert magic == 20000630 and version & 0xff == 2 and not version & 0x1a00, 'not a plain OpenEXR file'
    attributes, at = {}, 8
    while data[at]:
        name_end = data.index(0, at)
        type_end = data.index(0, name_end + 1)
        size, = struct.unpack_from('<I', data, type_end + 1)
        begin = type_end + 5
        attributes[data[at:name_end].decode()] = data[begin:begin + size]
        at = begin + size
    return attributes, at + 1


def channels_of(chlist):
    """(name, type) in the order of the file."""
    channels, at = [], 0
    while chlist[at]:
        end = chlist.index(0, at)
        channels.append((chlist[at:end].decode(), struct.unpack_from('<I', chlist, end + 1)[0]))
        at = end + 17
    return channels


def unzipped(block):
    """Undoes the deflate, the differences and the split into even and odd bytes."""
    plain = bytearray(zlib.decompress(block))
    for i in range(1, len(plain)):
        plain[i] = (plain[i] + plain[i - 1] - 128) & 0xff
    half = (len(plain) + 1) // 2
    joined = bytearray(len(plain))
    joined[0::2], joined[1::2] = plain[:half], plain[half:]
    return bytes(joined)


def read_pixel(data, x, y):
    """{channel: value} of the half channels at a pixel."""
    attributes, table = header_of(data)
    compression = attributes['compression'][0]
    assert compression in LINES_OF_BLOCK, f'compression {compression} is not read here'
    left, top, right, bottom = struct.unpack('<4i', attributes['dataWindow'])
    assert left <= x <= right and top <= y <= bottom, 'the pixel is outside'
    width, lines = right - left + 1, LINES_OF_BLOCK[compression]
    channels = channels_of(attributes['channels'])
    offset, = struct.unpack_from('<Q', data, table + 8 * ((y - top) // lines))
    first, size = struct.unpack_from('<ii', data, offset)
    block = data[offset + 8:offset + 8 + size]
    line_bytes = sum(BYTES_OF_TYPE[kind] for _, kind in channels) * width
    whole = line_bytes * min(lines, bottom + 1 - first)
    if compression != NONE and size < whole:
        block = unzipped(block)
    assert len(block) == whole, 'a block of another size'
    at, values = (y - first) * line_bytes, {}
    for name, kind in channels:
        if kind == HALF:
            values[name], = struct.unpack_from('<e', block, at + 2 * (x - left))
        at += BYTES_OF_TYPE[kind] * width
    return values
