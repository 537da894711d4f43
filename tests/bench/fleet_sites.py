"""SQL that fills a PostgreSQL database with sites over a continent, each flight with one map; for psql's input.

    python3 tests/bench/fleet_sites.py NUM_SITES MAP_HEAD_JSON | psql ...

The database must hold the accepted sites of one flight and its map: the new rows are copies of theirs, elsewhere.
"""

import json
import random
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "faults"))
import many_sites

WEST, SOUTH, EAST, NORTH = -9.0, 37.0, 30.0, 60.0
# Three rows of three fields.
SITES_OF_MAP = 9
SPACING_M = 130.0
HALF_FIELD_M = 60
METRES_PER_DEGREE = 111195.0


def head_of(base, latitude, longitude):
    head = dict(base, views=[], num_levels=many_sites.NUM_LEVELS, ranges={})
    head.pop("photo", None)
    half = many_sites.HALF_SIZE_M
    head["grid"] = {"west_m": -half, "north_m": half, "cell_size_m": 1.0, "num_rows": 2 * half, "num_cols": 2 * half}
    head["origin"] = {"latitude_deg": latitude, "longitude_deg": longitude, "altitude_m": 450.0}
    return head


def footprint():
    half = HALF_FIELD_M
    return [[-half, -half], [half, -half], [half, half], [-half, half]]


def main():
    num_sites = int(sys.argv[1])
    base = json.loads(sys.argv[2])
    generator = random.Random(7)
    print("BEGIN;\nCREATE TEMP TABLE places (number bigint, latitude float8, longitude float8, head text);")
    print("COPY places FROM STDIN;")
    for number in range(num_sites // SITES_OF_MAP):
        latitude, longitude = generator.uniform(SOUTH, NORTH), generator.uniform(WEST, EAST)
        head = json.dumps(head_of(base, latitude, longitude)).replace("\\", "\\\\")
        print(f"{number}\t{latitude!r}\t{longitude!r}\t{head}")
    print("\\.")
    keys = ", ".join(f"({level}, {row}, {col})" for level, row, col in many_sites.tile_keys())
    print(f"""
CREATE TEMP TABLE base AS SELECT * FROM sites WHERE is_recallable ORDER BY is_landable DESC LIMIT 1;
INSERT INTO maps (id, flight_id, number, head_json, altitude_datum, west_deg, south_deg, east_deg, north_deg, updated_at_us,
    seen_at_us, is_in_force)
  SELECT 'many' || number || '/1', 'many' || number, 1, head, 'amsl', longitude - 0.0027, latitude - 0.0018, longitude + 0.0027,
    latitude + 0.0018, updated_at_us, seen_at_us, true FROM places, base;
INSERT INTO map_areas SELECT id, 1, ST_MakeEnvelope(west_deg, south_deg, east_deg, north_deg, 4326) FROM maps
  WHERE flight_id LIKE 'many%';
INSERT INTO map_tiles SELECT 'many' || number || '/1', level, row, col, '\\x{many_sites.flat_tile().hex()}'::bytea
  FROM places, (VALUES {keys}) AS keys (level, row, col);
CREATE TEMP TABLE spots AS SELECT 'many' || number AS flight, site + 1 AS region,
    latitude + (site / 3 - 1) * {SPACING_M / METRES_PER_DEGREE} AS latitude,
    longitude + (site % 3 - 1) * {SPACING_M / METRES_PER_DEGREE} / cos(radians(latitude)) AS longitude
  FROM places, generate_series(0, {SITES_OF_MAP - 1}) AS site;
INSERT INTO sites (id, flight_id, region_id, map_id, latitude_deg, longitude_deg, feature_json, approach_json, replan_json,
    updated_at_us, seen_at_us, is_recallable, is_landable, altitude_m, altitude_datum, score, aircraft_json,
    west_deg, south_deg, east_deg, north_deg)
  SELECT flight || '-r' || region, flight, region, flight || '/1', latitude, longitude, feature_json, approach_json,
    (replan_json::jsonb || jsonb_build_object('latitude_deg', latitude, 'longitude_deg', longitude, 'altitude_m', 450.0,
      'area_m2', {4 * HALF_FIELD_M**2}, 'footprint_m', '{footprint()}'::jsonb))::text,
    updated_at_us, seen_at_us, true, true, 450.0, 'amsl', 0.8, aircraft_json,
    longitude - 0.0027, latitude - 0.0018, longitude + 0.0027, latitude + 0.0018 FROM spots, base;
INSERT INTO site_areas SELECT id, 1, ST_MakeEnvelope(west_deg, south_deg, east_deg, north_deg, 4326) FROM sites
  WHERE flight_id LIKE 'many%';
UPDATE versions SET value = value + 1;
COMMIT;
ANALYZE;""")


if __name__ == "__main__":
    main()
