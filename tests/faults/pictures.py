"""Pictures to send: photographs of a rendered flight, and files that attack their reader."""

import csv
import json
import os
import struct
import zlib
from pathlib import Path


class Flight:
    """What freelsd-render wrote: photographs, their poses, and the request of the flight."""

    def __init__(self, folder):
        folder = Path(folder)
        self.request = json.loads((folder / "flight.json").read_text())
        self.poses_csv = (folder / "poses.csv").read_text()
        self.names, self.images, self.metas = [], [], []
        for row in csv.DictReader(self.poses_csv.splitlines()):
            self.names.append(row["image"])
            self.images.append((folder / row["image"]).read_bytes())
            self.metas.append(meta_of(row))


def meta_of(row):
    """The meta object that says the same as a line of poses.csv."""
    number = lambda key: float(row[key])
    meta = {"timestamp_us": int(row["timestamp_us"]),
            "position": {key: number(key) for key in
                         ("latitude_deg", "longitude_deg", "altitude_m")},
            "attitude": {key: number(key) for key in ("roll_deg", "pitch_deg", "yaw_deg")}}
    return meta


def unlike(jpeg, number):
    """The same photograph as other bytes: a comment behind its first marker."""
    text = b"copy %d" % number
    return jpeg[:2] + b"\xff\xfe" + struct.pack(">H", len(text) + 2) + text + jpeg[2:]


def segment(marker, payload):
    return struct.pack(">BBH", 0xFF, marker, len(payload) + 2) + payload


def with_segment(jpeg, marker, payload):
    return jpeg[:2] + segment(marker, payload) + jpeg[2:]


def with_size(jpeg, width_px, height_px):
    """The same scan below a header that promises another size."""
    at = 2
    while at + 4 <= len(jpeg):
        marker, length = jpeg[at + 1], struct.unpack(">H", jpeg[at + 2:at + 4])[0]
        if 0xC0 <= marker <= 0xCF and marker not in (0xC4, 0xC8, 0xCC):
            return jpeg[:at + 5] + struct.pack(">HH", height_px, width_px) + jpeg[at + 9:]
        at += 2 + length
    raise ValueError("no start of frame")


def chunk(kind, payload):
    return struct.pack(">I", len(payload)) + kind + payload + \
        struct.pack(">I", zlib.crc32(kind + payload))


def png(width_px, height_px, rows=None, chunks=(), bit_depth=8, colour=2):
    """A PNG with more chunks before its data; without rows the data is one flat colour."""
    if rows is None:
        channels = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}[colour]
        size = (1 + (width_px * channels * bit_depth + 7) // 8) * height_px
        rows = zlib.compress(bytes(size), 9) if size < 1 << 28 else zlib.compress(bytes(1 << 20))
    header = struct.pack(">IIBBBBB", width_px, height_px, bit_depth, colour, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + \
        b"".join(chunk(kind, payload) for kind, payload in chunks) + \
        chunk(b"IDAT", rows) + chunk(b"IEND", b"")


def noise_png(width_px, height_px, grey=True):
    """Noise does not shrink: about as many bytes as pixels."""
    row_bytes = width_px * (1 if grey else 3)
    rows = b"".join(b"\0" + os.urandom(row_bytes) for _ in range(height_px))
    return png(width_px, height_px, zlib.compress(rows, 1), colour=0 if grey else 2)
