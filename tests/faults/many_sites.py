"""A data folder of many sites, made from one: each on a flat map of its own, on random places."""

import json
import random
import sqlite3
import struct
import zlib

TILE_CELLS = 128
HALF_SIZE_M = 200  # of a map with cells of 1 m
NUM_LEVELS = 3
MASK = (1 << 64) - 1


def flat_tile():
    """SerializeTile of a level meadow at height 0: see api/stored/map/tile.cc."""
    cells = TILE_CELLS * TILE_CELLS

    def steps(value):
        # Only the first differs from its neighbour.
        rest = bytes(cells - 1)
        return bytes([value & 255]) + rest + bytes([value >> 8]) + rest

    def part(content):
        deflated = zlib.compress(content, 6)
        return struct.pack("<III", len(content), len(deflated), zlib.crc32(content)) + deflated
    # Elevation, upper, deviation, points, slope, roughness, grass.
    planning = struct.pack("<i", 0) + b"".join(steps(n) for n in (0, 13, 13, 9, 0, 0, 251))
    display = bytes(cells) + bytes([9]) * cells + steps(1600)  # hazard, coverage, distance
    return b"FLMT" + struct.pack("<I", 2) + part(planning) + part(display) + part(b"")  # no cues


def checksum(*values):
    """See storage/sqlite/checksum.h."""
    state = 0xcbf29ce484222325

    def add(content):
        nonlocal state
        for byte in content:
            state = ((state ^ byte) * 0x100000001b3) & MASK
    for value in values:
        if isinstance(value, str):
            add(value.encode())
            add(struct.pack("<q", len(value.encode())))
        else:
            add(struct.pack("<d" if isinstance(value, float) else "<q", value))
    return state - (1 << 64) if state >> 63 else state


def tile_keys():
    for level in range(NUM_LEVELS):
        last = (HALF_SIZE_M - 1) // (TILE_CELLS << level)
        for row in range(-last - 1, last + 1):
            for col in range(-last - 1, last + 1):
                yield level, row, col


def map_rows(base, places):
    """Rows of maps with the head of the one that is there."""
    head = json.loads(base["head_json"])
    head.update(views=[], num_levels=NUM_LEVELS, ranges={})
    head.pop("photo", None)
    head["grid"] = {"west_m": -HALF_SIZE_M, "north_m": HALF_SIZE_M, "cell_size_m": 1.0,
                    "num_rows": 2 * HALF_SIZE_M, "num_cols": 2 * HALF_SIZE_M}
    for number, (latitude, longitude) in enumerate(places, start=1000):
        head["origin"] = {"latitude_deg": latitude, "longitude_deg": longitude, "altitude_m": 450.0}
        box = (longitude - 0.0027, latitude - 0.0018, longitude + 0.0027, latitude + 0.0018)
        row = [f"many/{number}", "many", json.dumps(head), base["altitude_datum"], *box,
               base["updated_at_us"], base["seen_at_us"]]
        yield row[:2] + [number] + row[2:] + [1, checksum(*row), None]


def fill(data, num_sites, half_side_deg=0.1):
    """Adds that many to the site that is there, in both files."""
    generator = random.Random(5)
    offsets = [(generator.uniform(-half_side_deg, half_side_deg),
                generator.uniform(-half_side_deg, half_side_deg)) for _ in range(num_sites)]
    maps = None
    for name in ("freelsd.db", "recall.db"):
        database = sqlite3.connect(data / name)
        site, base = first_row(database, "sites"), first_row(database, "maps")
        places = [(site["latitude_deg"] + north_deg, site["longitude_deg"] + east_deg)
                  for north_deg, east_deg in offsets]
        maps = maps or list(map_rows(base, places))
        fill_one(database, site, places, maps)
        database.commit()
        database.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        database.close()


def first_row(database, table):
    columns = [row[1] for row in database.execute(f"PRAGMA table_info({table})")]
    return dict(zip(columns, database.execute(f"SELECT * FROM {table}").fetchone()))


def insert(database, table, values):
    database.execute(f"INSERT INTO {table} VALUES ({','.join('?' * len(values))})", values)


def fill_one(database, base, places, maps):
    aircraft, datum = database.execute(
        "SELECT aircraft_json, altitude_datum FROM site_numbers").fetchone()
    replan = json.loads(base["replan_json"])
    replan["footprint_m"] = [[-60, -60], [60, -60], [60, 60], [-60, 60]]
    replan["area_m2"] = 14400.0
    replan["altitude_m"] = 450.0
    tile = flat_tile()
    for (latitude, longitude), map_row in zip(places, maps):
        number = map_row[2]
        replan["latitude_deg"], replan["longitude_deg"] = latitude, longitude
        row = dict(base, id=f"many-r{number}", flight_id="many", region_id=number,
                   latitude_deg=latitude, longitude_deg=longitude, replan_json=json.dumps(replan),
                   checksum=None, superseded_by=None, map_id=map_row[0])
        insert(database, "maps", map_row)
        for key in tile_keys():
            insert(database, "map_tiles", [map_row[0], *key, tile])
        insert(database, "sites", list(row.values()))
        insert(database, "site_numbers", [number, row["id"], 1, 1, 450.0, datum, 0.8, aircraft, None])
        insert(database, "site_boxes", [number, longitude - 0.0027, longitude + 0.0027,
                                        latitude - 0.0018, latitude + 0.0018])
