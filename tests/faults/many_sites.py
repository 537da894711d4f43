"""A data folder of many sites, made from one: flat maps on a lattice of places."""

import json
import random
import sqlite3
import struct
import zlib

NUM_CELLS = 400  # of 1 m, each way


def flat_map():
    """SerializeSiteMap of a level meadow at height 0: see api/export/site_map.cc."""
    cells = NUM_CELLS * NUM_CELLS

    def raster(value):
        single = struct.pack("<f", value)
        return b"".join(bytes([byte]) * cells for byte in single)
    half = NUM_CELLS / 2
    content = struct.pack("<dddiidd", -half, half, 1.0, NUM_CELLS, NUM_CELLS, 0.5, 0.1)
    for value in (0.0, 0.1, 0.1, 9.0, 0.0, 0.0, 0.99, 100.0):
        content += raster(value)
    content += bytes(cells)
    return b"FLSM" + struct.pack("<IQII", 1, len(content), zlib.crc32(content), 0) + \
        zlib.compress(content, 3)


def fill(data, num_sites, half_side_deg=0.1):
    """Adds that many to the site that is there, in both files."""
    generator = random.Random(5)
    places = [(generator.uniform(-half_side_deg, half_side_deg),
               generator.uniform(-half_side_deg, half_side_deg)) for _ in range(num_sites)]
    map_blob = flat_map()
    for name in ("freelsd.db", "recall.db"):
        database = sqlite3.connect(data / name)
        fill_one(database, places, map_blob)
        database.commit()
        database.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        database.close()


def fill_one(database, places, map_blob):
    site = database.execute("SELECT * FROM sites").fetchone()
    columns = [row[1] for row in database.execute("PRAGMA table_info(sites)")]
    base = dict(zip(columns, site))
    aircraft, datum = database.execute(
        "SELECT aircraft_json, altitude_datum FROM site_numbers").fetchone()
    replan = json.loads(base["replan_json"])
    replan["footprint_m"] = [[-60, -60], [60, -60], [60, 60], [-60, 60]]
    replan["area_m2"] = 14400.0
    replan["altitude_m"] = 450.0
    for number, (north_deg, east_deg) in enumerate(places, start=1000):
        latitude, longitude = base["latitude_deg"] + north_deg, base["longitude_deg"] + east_deg
        replan["latitude_deg"], replan["longitude_deg"] = latitude, longitude
        row = dict(base, id=f"many-r{number}", flight_id="many", region_id=number,
                   latitude_deg=latitude, longitude_deg=longitude, replan_json=json.dumps(replan),
                   checksum=None, superseded_by=None, is_checked=1)
        database.execute(f"INSERT INTO sites VALUES ({','.join('?' * len(columns))})",
                         [row[column] for column in columns])
        database.execute("INSERT INTO site_maps VALUES (?, ?)", (row["id"], map_blob))
        database.execute("INSERT INTO site_numbers VALUES (?, ?, 1, 1, 450.0, ?, 0.8, ?, NULL)",
                         (number, row["id"], datum, aircraft))
        database.execute("INSERT INTO site_boxes VALUES (?, ?, ?, ?, ?)",
                         (number, longitude - 0.0027, longitude + 0.0027, latitude - 0.0018,
                          latitude + 0.0018))
