"""The same sites as fleet_sites.py, in a data folder with SQLite that holds the accepted sites of one flight.

    python3 tests/bench/fleet_sites_sqlite.py DATA_FOLDER NUM_SITES PLACES_FILE
"""

import json
import math
import random
import sqlite3
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "faults"))
import many_sites
from fleet_sites import (EAST, HALF_FIELD_M, METRES_PER_DEGREE, NORTH, SITES_OF_MAP, SOUTH, SPACING_M, WEST, footprint,
                         head_of)


def spots(centre):
    step_deg = SPACING_M / METRES_PER_DEGREE
    for site in range(SITES_OF_MAP):
        yield (centre[0] + (site // 3 - 1) * step_deg,
               centre[1] + (site % 3 - 1) * step_deg / math.cos(math.radians(centre[0])))


def map_row(base, number, latitude, longitude):
    box = (longitude - 0.0027, latitude - 0.0018, longitude + 0.0027, latitude + 0.0018)
    row = [f"many{number}/1", f"many{number}", json.dumps(head_of(json.loads(base["head_json"]), latitude, longitude)), "amsl", *box,
           base["updated_at_us"], base["seen_at_us"]]
    return row[:2] + [1] + row[2:] + [1, many_sites.checksum(*row)]


def fill(database, centres, maps):
    columns = [row[1] for row in database.execute("PRAGMA table_info(sites)")]
    base = dict(zip(columns, database.execute(
        "SELECT sites.* FROM sites JOIN site_numbers ON site_id = id WHERE is_recallable ORDER BY is_landable DESC").fetchone()))
    aircraft = database.execute("SELECT aircraft_json FROM site_numbers WHERE is_recallable").fetchone()[0]
    replan = dict(json.loads(base["replan_json"]), altitude_m=450.0, area_m2=4 * HALF_FIELD_M**2,
                  footprint_m=footprint())
    tile = many_sites.flat_tile()
    number = 1000
    for centre, row in zip(centres, maps):
        many_sites.insert(database, "maps", row)
        for key in many_sites.tile_keys():
            many_sites.insert(database, "map_tiles", [row[0], *key, tile])
        for latitude, longitude in spots(centre):
            number += 1
            replan["latitude_deg"], replan["longitude_deg"] = latitude, longitude
            site = dict(base, id=f"{row[1]}-r{number}", flight_id=row[1], region_id=number, latitude_deg=latitude,
                        longitude_deg=longitude, replan_json=json.dumps(replan), checksum=None, superseded_by=None,
                        map_id=row[0])
            many_sites.insert(database, "sites", list(site.values()))
            many_sites.insert(database, "site_numbers", [number, site["id"], 1, 1, 450.0, "amsl", 0.8, aircraft, None])
            many_sites.insert(database, "site_boxes", [number, longitude - 0.0027, longitude + 0.0027,
                                                       latitude - 0.0018, latitude + 0.0018])


def main():
    folder, num_sites = Path(sys.argv[1]), int(sys.argv[2])
    generator = random.Random(7)
    centres = [(generator.uniform(SOUTH, NORTH), generator.uniform(WEST, EAST)) for _ in range(num_sites // SITES_OF_MAP)]
    maps = None
    for name in ("freelsd.db", "recall.db"):
        database = sqlite3.connect(folder / name)
        base = many_sites.first_row(database, "maps")
        maps = maps or [map_row(base, number, *centre) for number, centre in enumerate(centres, start=1000)]
        fill(database, centres, maps)
        database.commit()
        database.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        database.close()
    Path(sys.argv[3]).write_text("".join(f"{latitude} {longitude}\n" for latitude, longitude in centres[::5]))


if __name__ == "__main__":
    main()
