#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Control networks of ISIS, read and written without the program: wire format of protocol buffers,
versions 2 and 5.

Usage: control_network.py IN.net OUT.net --version 2|5     writes the same network in that version
A message is kept as a list of (field, wire type, value), so that nothing of it is lost."""
import argparse
import re
import struct


def varint(value):
    out = bytearray()
    while value > 127:
        out.append(value & 127 | 128)
        value >>= 7
    out.append(value)
    return bytes(out)


def take_varint(data, at):
    value = shift = 0
    while True:
        byte = data[at]
        at += 1
        value |= (byte & 127) << shift
        shift += 7
        if byte < 128:
            return value, at


def parse(data):
    """The fields of a message."""
    fields, at = [], 0
    while at < len(data):
        key, at = take_varint(data, at)
        number, kind = key >> 3, key & 7
        if kind == 0:
            value, at = take_varint(data, at)
        elif kind == 1:
            value, at = struct.unpack_from("<d", data, at)[0], at + 8
        elif kind == 2:
            size, at = take_varint(data, at)
            value, at = data[at:at + size], at + size
        else:
            raise ValueError(f"wire type {kind}")
        fields.append((number, kind, value))
    return fields


def message(fields):
    out = b""
    for number, kind, value in fields:
        out += varint(number << 3 | kind)
        if kind == 0:
            out += varint(value)
        elif kind == 1:
            out += struct.pack("<d", value)
        else:
            out += varint(len(value)) + value
    return out


def read(path):
    """Target and the points' messages as bytes."""
    with open(path, "rb") as stream:
        data = stream.read()
    label = data[:65536].decode("latin-1")

    def number(name):
        return int(re.search(rf"{name}\s*=\s*(\d+)", label).group(1))
    start, size = number("HeaderStartByte"), number("HeaderBytes")
    header = parse(data[start:start + size])
    at, end = number("PointsStartByte"), number("PointsStartByte") + number("PointsBytes")
    points = []
    if number("Version") == 5:
        while at < end:
            size = struct.unpack_from("<I", data, at)[0]
            points.append(data[at + 4:at + 4 + size])
            at += 4 + size
    else:
        sizes = next(value for field, _, value in header if field == 7)
        place = 0
        while place < len(sizes):
            size, place = take_varint(sizes, place)
            points.append(data[at:at + size])
            at += size
    header = [field for field in header if field[0] != 7]
    return header, points


def network_bytes(header, points, version, start=65536):
    """A network file. `start` is where the header stands; the label must fit before it."""
    if version == 5:
        body = b"".join(struct.pack("<I", len(point)) + point for point in points)
        head = message(header)
    else:
        body = b"".join(points)
        head = message(header + [(7, 2, b"".join(varint(len(point)) for point in points))])
    measures = sum(1 for point in points for field in parse(point) if field[0] == 25)
    target = next((value.decode() for field, _, value in header if field == 2), "")
    label = f"""Object = ProtoBuffer
  Object = Core
    HeaderStartByte = {start}
    HeaderBytes     = {len(head)}
    PointsStartByte = {start + len(head)}
    PointsBytes     = {len(body)}
  End_Object

  # This group is for informational purposes only
  Group = ControlNetworkInfo
    NetworkId        = Test
    TargetName       = {target}
    NumberOfPoints   = {len(points)}
    NumberOfMeasures = {measures}
    Version          = {version}
  End_Group
End_Object
End
""".encode()
    assert len(label) <= start, "the label does not fit"
    return label + b"\0" * (start - len(label)) + head + body


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("source")
    parser.add_argument("target")
    parser.add_argument("--version", type=int, choices=(2, 5), required=True)
    arguments = parser.parse_args()
    header, points = read(arguments.source)
    with open(arguments.target, "wb") as stream:
        stream.write(network_bytes(header, points, arguments.version))


if __name__ == "__main__":
    main()
