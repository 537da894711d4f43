#include "storage/sqlite/migrations.h"

#include "storage/sqlite/map_rows.h"

namespace freelsd {
namespace {

// Only migrations read JSON in storage: version 1 stored the values of the new columns in the
// sites' features alone. It stored no extent of a map; a box of about 3 km is larger than any map.
constexpr char kFrom1To2[] = R"sql(
ALTER TABLE flights ADD COLUMN has_retired_images INTEGER NOT NULL DEFAULT 0;
ALTER TABLE frames ADD COLUMN tags_json TEXT NOT NULL DEFAULT '{}';
ALTER TABLE frames ADD COLUMN resolved_json TEXT NOT NULL DEFAULT '';
UPDATE frames SET resolved_json = meta_json;
CREATE TABLE telemetry (
  flight_id TEXT NOT NULL REFERENCES flights (id) ON DELETE CASCADE,
  kind INTEGER NOT NULL,
  timestamp_us INTEGER NOT NULL,
  value_0 REAL NOT NULL,
  value_1 REAL NOT NULL,
  value_2 REAL NOT NULL,
  value_3 REAL NOT NULL,
  PRIMARY KEY (flight_id, kind, timestamp_us)
) STRICT, WITHOUT ROWID;
ALTER TABLE sites ADD COLUMN checksum INTEGER;
ALTER TABLE sites ADD COLUMN superseded_by TEXT
  REFERENCES sites (id) ON DELETE SET NULL DEFERRABLE INITIALLY DEFERRED;
CREATE INDEX sites_superseded ON sites (superseded_by) WHERE superseded_by IS NOT NULL;
CREATE TABLE site_numbers (
  number INTEGER PRIMARY KEY,
  site_id TEXT NOT NULL UNIQUE REFERENCES sites (id) ON DELETE CASCADE,
  is_recallable INTEGER NOT NULL,
  is_landable INTEGER NOT NULL,
  altitude_m REAL NOT NULL,
  altitude_datum TEXT NOT NULL,
  score REAL NOT NULL,
  aircraft_json TEXT NOT NULL,
  checksum INTEGER
) STRICT;
CREATE INDEX site_numbers_by_altitude ON site_numbers (altitude_m) WHERE is_recallable = 1;
CREATE VIRTUAL TABLE site_boxes USING rtree (
  number, west_deg, east_deg, south_deg, north_deg
);
INSERT INTO site_numbers (site_id, is_recallable, is_landable, altitude_m, altitude_datum, score,
                          aircraft_json)
SELECT id,
       coalesce(json_extract(feature_json, '$.properties.verdict') IN ('landable', 'unverified')
                AND json_type(feature_json, '$.properties.elevation_m') IN ('real', 'integer'), 0),
       coalesce(json_extract(feature_json, '$.properties.verdict') = 'landable', 0),
       coalesce(CAST(json_extract(feature_json, '$.properties.elevation_m') AS REAL), 0.0),
       coalesce(json_extract(feature_json, '$.properties.altitude_datum'), 'unknown'),
       coalesce(CAST(json_extract(feature_json, '$.properties.score') AS REAL), 0.0),
       coalesce(json_extract(feature_json, '$.properties.aircraft'), '{}')
FROM sites;
INSERT INTO site_boxes
SELECT number, longitude_deg - 0.03, longitude_deg + 0.03, latitude_deg - 0.015,
       latitude_deg + 0.015
FROM site_numbers JOIN sites ON sites.id = site_numbers.site_id;
)sql";

// The ground was last photographed before the site was written, so updated_at_us is the latest
// possible time. Checksums are dropped because they cover the new columns too.
constexpr char kFrom2To3[] = R"sql(
ALTER TABLE sites ADD COLUMN seen_at_us INTEGER NOT NULL DEFAULT 0;
ALTER TABLE sites ADD COLUMN is_evidence INTEGER NOT NULL DEFAULT 0;
UPDATE sites SET seen_at_us = updated_at_us, checksum = NULL,
  is_evidence = (SELECT is_recallable FROM site_numbers WHERE site_id = id);
UPDATE site_numbers SET checksum = NULL;
)sql";

// Up to version 3, superseded_by was decided by the rectangles of regions. It stays until the
// server has checked the site's plan on later maps. Checksums are dropped because they covered
// is_evidence.
constexpr char kFrom3To4[] = R"sql(
ALTER TABLE sites DROP COLUMN is_evidence;
ALTER TABLE sites ADD COLUMN superseded_at_us INTEGER;
ALTER TABLE sites ADD COLUMN superseded_reason TEXT NOT NULL DEFAULT '';
ALTER TABLE sites ADD COLUMN superseded_detail TEXT NOT NULL DEFAULT '';
ALTER TABLE sites ADD COLUMN confirmed_at_us INTEGER;
ALTER TABLE sites ADD COLUMN is_checked INTEGER NOT NULL DEFAULT 0;
CREATE INDEX sites_confirmed ON sites (confirmed_at_us) WHERE confirmed_at_us IS NOT NULL;
CREATE INDEX sites_unchecked ON sites (id) WHERE is_checked = 0;
UPDATE sites SET checksum = NULL;
)sql";

// Maps of rejected sites were stored with an unknown datum. The flight's request in replan_json, a
// JSON text within JSON, has the true one. Checksums cover the datum.
constexpr char kFrom4To5[] = R"sql(
WITH flights_of_sites AS (
  SELECT id, CASE WHEN json_valid(replan_json) THEN json_extract(replan_json, '$.flight') END
    AS request_json FROM sites
), datums AS (
  SELECT id, CASE WHEN json_valid(request_json)
    THEN json_extract(request_json, '$.altitude_datum') END AS datum FROM flights_of_sites
)
UPDATE site_numbers SET altitude_datum = datum, checksum = NULL
FROM datums
WHERE datums.id = site_id AND is_recallable = 0 AND datum IN ('amsl', 'ellipsoid');
)sql";

// Arrivals were not stored. Samples keep the order of their own times, below 0 because the time of
// arrival is unknown; times outside 1970 to 2255 are cut, so that no sum leaves its range.
constexpr char kFrom5To6[] = R"sql(
ALTER TABLE frames ADD COLUMN arrived_at_us INTEGER NOT NULL DEFAULT 0;
ALTER TABLE telemetry ADD COLUMN arrived_at_us INTEGER NOT NULL DEFAULT 0;
UPDATE telemetry
SET arrived_at_us = max(0, min(9000000000000000, timestamp_us)) - 9000000000000001;
CREATE INDEX telemetry_by_arrival ON telemetry (flight_id, kind, arrived_at_us);
)sql";

constexpr char kFrom6To7[] = R"sql(
CREATE TABLE obstacles (
  id TEXT PRIMARY KEY,
  feature_json TEXT NOT NULL,
  west_deg REAL NOT NULL,
  south_deg REAL NOT NULL,
  east_deg REAL NOT NULL,
  north_deg REAL NOT NULL,
  expires_at_us INTEGER,
  updated_at_us INTEGER NOT NULL,
  checksum INTEGER NOT NULL
) STRICT;
)sql";

// A site may be superseded by a map without sites, so superseded_by refers to no row any more.
// SQLite cannot drop a foreign key, so the table is written anew, while foreign keys are off.
constexpr char kFrom7To8[] = R"sql(
CREATE TABLE new_sites (
  id TEXT PRIMARY KEY,
  flight_id TEXT NOT NULL,
  region_id INTEGER NOT NULL,
  latitude_deg REAL NOT NULL,
  longitude_deg REAL NOT NULL,
  feature_json TEXT NOT NULL,
  approach_json TEXT NOT NULL,
  replan_json TEXT NOT NULL,
  updated_at_us INTEGER NOT NULL,
  checksum INTEGER,
  superseded_by TEXT,
  seen_at_us INTEGER NOT NULL DEFAULT 0,
  superseded_at_us INTEGER,
  superseded_reason TEXT NOT NULL DEFAULT '',
  superseded_detail TEXT NOT NULL DEFAULT '',
  confirmed_at_us INTEGER,
  is_checked INTEGER NOT NULL DEFAULT 0,
  map_id TEXT NOT NULL DEFAULT '',
  superseded_by_map TEXT NOT NULL DEFAULT ''
) STRICT;
INSERT INTO new_sites (id, flight_id, region_id, latitude_deg, longitude_deg, feature_json,
  approach_json, replan_json, updated_at_us, checksum, superseded_by, seen_at_us, superseded_at_us,
  superseded_reason, superseded_detail, confirmed_at_us, is_checked)
SELECT id, flight_id, region_id, latitude_deg, longitude_deg, feature_json, approach_json,
  replan_json, updated_at_us, checksum, superseded_by, seen_at_us, superseded_at_us,
  superseded_reason, superseded_detail, confirmed_at_us, is_checked FROM sites;
DROP TABLE sites;
ALTER TABLE new_sites RENAME TO sites;
CREATE INDEX sites_superseded ON sites (superseded_by) WHERE superseded_by IS NOT NULL;
CREATE INDEX sites_confirmed ON sites (confirmed_at_us) WHERE confirmed_at_us IS NOT NULL;
CREATE INDEX sites_unchecked ON sites (id) WHERE is_checked = 0;
CREATE INDEX sites_by_flight ON sites (flight_id);
CREATE INDEX sites_by_place ON sites (latitude_deg, longitude_deg);
CREATE INDEX sites_by_map ON sites (map_id) WHERE map_id <> '';
CREATE INDEX sites_superseded_by_map ON sites (superseded_by_map) WHERE superseded_by_map <> '';
CREATE TABLE maps (
  id TEXT PRIMARY KEY,
  flight_id TEXT NOT NULL,
  number INTEGER NOT NULL,
  head_json TEXT NOT NULL,
  altitude_datum TEXT NOT NULL,
  west_deg REAL NOT NULL,
  south_deg REAL NOT NULL,
  east_deg REAL NOT NULL,
  north_deg REAL NOT NULL,
  updated_at_us INTEGER NOT NULL,
  seen_at_us INTEGER NOT NULL,
  is_in_force INTEGER NOT NULL,
  checksum INTEGER NOT NULL
) STRICT;
CREATE UNIQUE INDEX maps_by_flight ON maps (flight_id, number);
CREATE INDEX maps_by_latitude ON maps (south_deg, north_deg) WHERE is_in_force = 1;

CREATE TABLE map_tiles (
  map_id TEXT NOT NULL REFERENCES maps (id) ON DELETE CASCADE,
  level INTEGER NOT NULL,
  row INTEGER NOT NULL,
  col INTEGER NOT NULL,
  tile BLOB NOT NULL,
  PRIMARY KEY (map_id, level, row, col)
) STRICT;

CREATE TABLE photo_tiles (
  map_id TEXT NOT NULL REFERENCES maps (id) ON DELETE CASCADE,
  level INTEGER NOT NULL,
  row INTEGER NOT NULL,
  col INTEGER NOT NULL,
  sha256 TEXT NOT NULL,
  PRIMARY KEY (map_id, level, row, col)
) STRICT, WITHOUT ROWID;
CREATE INDEX photo_tiles_by_image ON photo_tiles (sha256);
)sql";

// Everything that is stored already is told as if it had just been stored.
constexpr char kFrom8To9[] = R"sql(
CREATE TABLE feed (
  id TEXT NOT NULL,
  number INTEGER NOT NULL,
  forgotten_through INTEGER NOT NULL,
  is_from_above INTEGER NOT NULL
) STRICT;
INSERT INTO feed VALUES (lower(hex(randomblob(8))), 0, 0, 0);
CREATE TABLE changes (
  subject INTEGER NOT NULL,
  id TEXT NOT NULL,
  number INTEGER NOT NULL UNIQUE,
  kind INTEGER NOT NULL,
  changed_at_us INTEGER NOT NULL,
  stamp_us INTEGER NOT NULL,
  west_deg REAL NOT NULL,
  south_deg REAL NOT NULL,
  east_deg REAL NOT NULL,
  north_deg REAL NOT NULL,
  origin TEXT NOT NULL DEFAULT '',
  is_known_above INTEGER NOT NULL,
  PRIMARY KEY (subject, id)
) STRICT, WITHOUT ROWID;
CREATE INDEX changes_unknown_above ON changes (number) WHERE is_known_above = 0;
CREATE INDEX changes_removed ON changes (changed_at_us) WHERE kind >= 4;
CREATE VIEW told_changes AS
  SELECT subject, id, kind, stamp_us, west_deg, south_deg, east_deg, north_deg FROM changes;
CREATE TRIGGER change_is_told INSTEAD OF INSERT ON told_changes
WHEN EXISTS (SELECT 1 FROM feed) BEGIN
  UPDATE feed SET number = number + 1;
  INSERT INTO changes (subject, id, number, kind, changed_at_us, stamp_us, west_deg, south_deg,
    east_deg, north_deg, is_known_above)
  SELECT NEW.subject, NEW.id, number, NEW.kind,
    CAST((julianday('now') - 2440587.5) * 86400000000.0 AS INTEGER), NEW.stamp_us, NEW.west_deg,
    NEW.south_deg, NEW.east_deg, NEW.north_deg, is_from_above FROM feed WHERE true
  ON CONFLICT (subject, id) DO UPDATE SET
    number = excluded.number,
    kind = CASE WHEN excluded.kind = 0 AND kind < 4 THEN 1 ELSE excluded.kind END,
    changed_at_us = excluded.changed_at_us,
    stamp_us = excluded.stamp_us,
    west_deg = min(west_deg, excluded.west_deg),
    south_deg = min(south_deg, excluded.south_deg),
    east_deg = max(east_deg, excluded.east_deg),
    north_deg = max(north_deg, excluded.north_deg),
    origin = iif(stamp_us = excluded.stamp_us, origin, ''),
    is_known_above = excluded.is_known_above;
END;
CREATE TRIGGER site_is_stored AFTER INSERT ON sites BEGIN
  INSERT INTO told_changes VALUES (0, NEW.id, 0, NEW.updated_at_us, NEW.longitude_deg,
    NEW.latitude_deg, NEW.longitude_deg, NEW.latitude_deg);
END;
CREATE TRIGGER site_is_updated AFTER UPDATE OF feature_json ON sites BEGIN
  INSERT INTO told_changes VALUES (0, NEW.id, 1, NEW.updated_at_us, NEW.longitude_deg,
    NEW.latitude_deg, NEW.longitude_deg, NEW.latitude_deg);
END;
CREATE TRIGGER site_stands_otherwise AFTER UPDATE OF superseded_by ON sites
WHEN NEW.superseded_by IS NOT OLD.superseded_by
  OR NEW.superseded_by_map <> OLD.superseded_by_map
  OR NEW.superseded_at_us IS NOT OLD.superseded_at_us
  OR NEW.superseded_reason <> OLD.superseded_reason
  OR NEW.superseded_detail <> OLD.superseded_detail
  OR NEW.confirmed_at_us IS NOT OLD.confirmed_at_us BEGIN
  INSERT INTO told_changes VALUES (0, NEW.id,
    CASE WHEN NEW.superseded_by IS NOT NULL THEN 2
         WHEN NEW.confirmed_at_us IS NOT OLD.confirmed_at_us THEN 3 ELSE 1 END,
    NEW.updated_at_us, NEW.longitude_deg, NEW.latitude_deg, NEW.longitude_deg, NEW.latitude_deg);
END;
CREATE TRIGGER site_is_removed AFTER DELETE ON sites BEGIN
  INSERT INTO told_changes VALUES (0, OLD.id, 4, OLD.updated_at_us, OLD.longitude_deg,
    OLD.latitude_deg, OLD.longitude_deg, OLD.latitude_deg);
END;
CREATE TRIGGER map_is_stored AFTER INSERT ON maps WHEN NEW.is_in_force = 1 BEGIN
  INSERT INTO told_changes VALUES (1, NEW.id, 0, NEW.updated_at_us,
    iif(NEW.west_deg > NEW.east_deg, -180, NEW.west_deg), NEW.south_deg,
    iif(NEW.west_deg > NEW.east_deg, 180, NEW.east_deg), NEW.north_deg);
END;
CREATE TRIGGER map_comes_in_force AFTER UPDATE OF is_in_force ON maps
WHEN NEW.is_in_force = 1 AND OLD.is_in_force = 0 BEGIN
  INSERT INTO told_changes VALUES (1, NEW.id, 0, NEW.updated_at_us,
    iif(NEW.west_deg > NEW.east_deg, -180, NEW.west_deg), NEW.south_deg,
    iif(NEW.west_deg > NEW.east_deg, 180, NEW.east_deg), NEW.north_deg);
END;
CREATE TRIGGER map_is_removed AFTER DELETE ON maps WHEN OLD.is_in_force = 1 BEGIN
  INSERT INTO told_changes VALUES (1, OLD.id, 4, OLD.updated_at_us,
    iif(OLD.west_deg > OLD.east_deg, -180, OLD.west_deg), OLD.south_deg,
    iif(OLD.west_deg > OLD.east_deg, 180, OLD.east_deg), OLD.north_deg);
END;
CREATE TRIGGER obstacle_is_stored AFTER INSERT ON obstacles BEGIN
  INSERT INTO told_changes VALUES (2, NEW.id, 0, NEW.updated_at_us, NEW.west_deg, NEW.south_deg,
    NEW.east_deg, NEW.north_deg);
END;
CREATE TRIGGER obstacle_is_updated AFTER UPDATE OF feature_json ON obstacles BEGIN
  INSERT INTO told_changes VALUES (2, NEW.id, 1, NEW.updated_at_us, NEW.west_deg, NEW.south_deg,
    NEW.east_deg, NEW.north_deg);
END;
CREATE TRIGGER obstacle_is_removed AFTER DELETE ON obstacles BEGIN
  INSERT INTO told_changes VALUES (2, OLD.id,
    iif(OLD.expires_at_us < (julianday('now') - 2440587.5) * 86400000000.0, 5, 4),
    OLD.updated_at_us, OLD.west_deg, OLD.south_deg, OLD.east_deg, OLD.north_deg);
END;
CREATE TABLE follow_state (
  followed TEXT PRIMARY KEY,
  next TEXT NOT NULL,
  in_step_at_us INTEGER
) STRICT;
INSERT INTO told_changes SELECT 1, id, 0, updated_at_us, iif(west_deg > east_deg, -180, west_deg),
  south_deg, iif(west_deg > east_deg, 180, east_deg), north_deg
  FROM maps WHERE is_in_force = 1 ORDER BY id;
INSERT INTO told_changes SELECT 0, id, 0, updated_at_us, longitude_deg, latitude_deg, longitude_deg,
  latitude_deg FROM sites ORDER BY id;
INSERT INTO told_changes SELECT 2, id, 0, updated_at_us, west_deg, south_deg, east_deg, north_deg
  FROM obstacles ORDER BY id;
)sql";

constexpr char kFrom9To10[] =
    "CREATE INDEX site_numbers_by_aircraft ON site_numbers (aircraft_json) WHERE is_recallable = 1";

constexpr char kFrom10To11[] = R"sql(
ALTER TABLE sites ADD COLUMN seen_until_us INTEGER;
ALTER TABLE maps ADD COLUMN seen_until_us INTEGER;
)sql";

// Up to version 10, an unknown time was stored as that of the evaluation. Those of maps come first.
constexpr char kUnknownTimesOfSites[] = R"sql(
UPDATE sites SET checksum = NULL, seen_until_us = nullif(updated_at_us, 0), seen_at_us = coalesce(
  (SELECT seen_at_us FROM maps WHERE maps.id = map_id AND maps.seen_until_us IS NULL), 0)
WHERE seen_at_us = updated_at_us;
UPDATE sites SET seen_until_us = NULL WHERE seen_at_us > 0;
UPDATE site_numbers SET checksum = NULL
WHERE site_id IN (SELECT id FROM sites WHERE checksum IS NULL);
UPDATE sites SET is_checked = 0;
)sql";

}  // namespace

void Migrate(const Connection& writer, int64_t version) {
  if (version < 2) writer.Execute(kFrom1To2);
  if (version < 3) writer.Execute(kFrom2To3);
  if (version < 4) writer.Execute(kFrom3To4);
  if (version < 5) writer.Execute(kFrom4To5);
  if (version < 6) writer.Execute(kFrom5To6);
  if (version < 7) writer.Execute(kFrom6To7);
  if (version < 8) writer.Execute(kFrom7To8);
  if (version < 9) writer.Execute(kFrom8To9);
  if (version < 10) writer.Execute(kFrom9To10);
  if (version < 11) {
    writer.Execute(kFrom10To11);
    ForgetUnknownTimesOfMaps(writer);
    writer.Execute(kUnknownTimesOfSites);
  }
}

}  // namespace freelsd
