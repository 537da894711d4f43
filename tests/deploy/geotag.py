#!/usr/bin/env python3
"""Photographs as a drone leaves them: place, time and lens of a rendered flight go into each JPEG's EXIF.

    tests/deploy/geotag.py RENDERED_FOLDER NEW_FOLDER [NUM_PHOTOGRAPHS]

No attitude, no poses.csv, no flight.json: what is not in the photographs is not there.
"""
import csv
import datetime
import json
import pathlib
import struct
import sys

BYTE, ASCII, SHORT, LONG, RATIONAL = 1, 2, 3, 4, 5
SENSOR_WIDTH_MM = 7.52


def rational(value, parts):
    return struct.pack("<II", round(value * parts), parts)


def degrees(value):
    whole = int(abs(value))
    minutes = int((abs(value) - whole) * 60)
    seconds = ((abs(value) - whole) * 60 - minutes) * 60
    return rational(whole, 1) + rational(minutes, 1) + rational(seconds, 1000000)


def directory(at, entries):
    """An image file directory at an offset of the TIFF block: (tag, type, count, bytes), by tag."""
    after = at + 2 + 12 * len(entries) + 4
    head, tail = struct.pack("<H", len(entries)), b""
    for tag, kind, count, data in sorted(entries):
        if len(data) > 4:
            data, tail = struct.pack("<I", after + len(tail)), tail + data
        head += struct.pack("<HHI", tag, kind, count) + data.ljust(4, b"\0")
    return head + b"\0\0\0\0" + tail


def exif(pose, camera):
    time = datetime.datetime.fromtimestamp(int(pose["timestamp_us"]) / 1e6, datetime.timezone.utc)
    latitude, longitude = float(pose["latitude_deg"]), float(pose["longitude_deg"])
    pixels_per_mm = camera["width_px"] / SENSOR_WIDTH_MM
    photo = [
        (0x9003, ASCII, 20, time.strftime("%Y:%m:%d %H:%M:%S").encode() + b"\0"),
        (0x9291, ASCII, 7, b"%06d\0" % time.microsecond),
        (0x920A, RATIONAL, 1, rational(camera["fx_px"] / pixels_per_mm, 100000)),
        (0xA20E, RATIONAL, 1, rational(pixels_per_mm * 10, 1000)),
        (0xA20F, RATIONAL, 1, rational(pixels_per_mm * 10, 1000)),
        (0xA210, SHORT, 1, struct.pack("<H", 3)),  # per centimetre
    ]
    place = [
        (1, ASCII, 2, b"N\0" if latitude >= 0 else b"S\0"),
        (2, RATIONAL, 3, degrees(latitude)),
        (3, ASCII, 2, b"E\0" if longitude >= 0 else b"W\0"),
        (4, RATIONAL, 3, degrees(longitude)),
        (5, BYTE, 1, b"\0"),  # above sea level
        (6, RATIONAL, 1, rational(float(pose["altitude_m"]), 1000)),
    ]
    photo_at = 8 + 2 + 2 * 12 + 4
    photo_bytes = directory(photo_at, photo)
    place_at = photo_at + len(photo_bytes)
    first = [
        (0x8769, LONG, 1, struct.pack("<I", photo_at)),
        (0x8825, LONG, 1, struct.pack("<I", place_at)),
    ]
    block = b"II*\0\x08\0\0\0" + directory(8, first) + photo_bytes + directory(place_at, place)
    return b"Exif\0\0" + block


def main(rendered, out, num_photographs=None):
    rendered, out = pathlib.Path(rendered), pathlib.Path(out)
    out.mkdir(parents=True, exist_ok=True)
    camera = json.loads((rendered / "flight.json").read_text())["camera"]
    with open(rendered / "poses.csv", newline="") as table:
        poses = list(csv.DictReader(table))
    for pose in poses[: int(num_photographs) if num_photographs else None]:
        jpeg = (rendered / pose["image"]).read_bytes()
        payload = exif(pose, camera)
        segment = b"\xff\xe1" + struct.pack(">H", len(payload) + 2) + payload
        (out / pose["image"]).write_bytes(jpeg[:2] + segment + jpeg[2:])


if __name__ == "__main__":
    main(*sys.argv[1:])
