#!/usr/bin/env python3
"""Prints how much a recorded wind has changed after some time (decision 0045).

Usage: wind_change.py PATH...   each a wind.csv (time_ms, wind.speed, wind.direction) or a MAVLink
       log, NAME.tlog or NAME.tlog.xz; several logs are taken together
Only differences count, so it does not matter whether a direction is that from or to which the wind blows.
"""
import csv
import lzma
import math
import struct
import sys

LAGS_S = (1, 2, 5, 10, 20, 30, 60, 120, 180, 240, 300, 400, 500, 600)
MIN_PAIRS = 30
MIN_SPEED_MPS = 0.01  # before the first estimate
MIN_HEIGHT_M = 40.0  # of a MAVLink log: below, the wind of the simulation depends on the height
WIND, GLOBAL_POSITION_INT = 168, 33


def of_csv(path):
    with open(path, encoding="utf-8") as file:
        for row in csv.DictReader(file):
            yield int(row["time_ms"]) * 1e-3, float(row["wind.speed"]), float(row["wind.direction"])


def packets(data):
    """Time in microseconds, number and payload of each MAVLink packet."""
    start = 0
    while start + 18 < len(data):
        time_us, at = struct.unpack_from(">Q", data, start)[0], start + 8
        if data[at] == 0xFD:
            number = int.from_bytes(data[at + 7 : at + 10], "little")
            yield time_us, number, data[at + 10 : at + 10 + data[at + 1]]
            start = at + 12 + data[at + 1] + (13 if data[at + 2] & 1 else 0)
        else:
            yield time_us, data[at + 5], data[at + 6 : at + 6 + data[at + 1]]
            start = at + 8 + data[at + 1]


def of_log(path):
    with (lzma.open if path.endswith(".xz") else open)(path, "rb") as file:
        data = file.read()
    height_m = 0.0
    for time_us, number, payload in packets(data):
        payload = payload.ljust(28, b"\0")
        if number == GLOBAL_POSITION_INT:
            height_m = struct.unpack_from("<i", payload, 16)[0] * 1e-3
        elif number == WIND and height_m >= MIN_HEIGHT_M:
            direction_deg, speed_mps = struct.unpack_from("<ff", payload)
            yield time_us * 1e-6, speed_mps, direction_deg


def vectors(samples):
    return [(time_s, speed * math.sin(math.radians(direction)), speed * math.cos(math.radians(direction)))
            for time_s, speed, direction in samples if speed >= MIN_SPEED_MPS]


def differences(winds, lag_s):
    later = 0
    for time_s, east, north in winds:
        while later < len(winds) and winds[later][0] < time_s + lag_s:
            later += 1
        if later < len(winds) and winds[later][0] < time_s + 1.2 * lag_s + 0.5:
            yield math.hypot(winds[later][1] - east, winds[later][2] - north)


def table(name, records):
    speeds = [math.hypot(east, north) for winds in records for _, east, north in winds]
    print(f"{name}: {len(speeds)} winds, mean speed {sum(speeds) / len(speeds):.1f} m/s")
    print("   lag   pairs  deviation in each axis  95 % within")
    for lag_s in LAGS_S:
        found = sorted(d for winds in records for d in differences(winds, lag_s))
        if len(found) < MIN_PAIRS:
            continue
        deviation = math.sqrt(sum(d * d for d in found) / len(found) / 2)
        print(f"{lag_s:5d} s {len(found):6d} {deviation:15.2f} m/s {found[int(0.95 * len(found))]:14.2f} m/s")


def main(paths):
    logs = [path for path in paths if not path.endswith(".csv")]
    for path in paths:
        if path not in logs:
            table(path, [vectors(of_csv(path))])
    if logs:
        table(f"{len(logs)} logs", [vectors(of_log(path)) for path in logs])


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    main(sys.argv[1:])
