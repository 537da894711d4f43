-- A database as 0.1.0 wrote it: its schema without comments, and rows with their checksums.
PRAGMA foreign_keys = OFF;
CREATE TABLE flights (
  id TEXT PRIMARY KEY,
  name TEXT NOT NULL,
  request_json TEXT NOT NULL,
  rig_json TEXT NOT NULL,
  warnings_json TEXT NOT NULL,
  stages_json TEXT NOT NULL,
  created_at_us INTEGER NOT NULL,
  num_rejected_frames INTEGER NOT NULL,
  has_failed INTEGER NOT NULL,
  ground_altitude_m REAL,
  has_retired_images INTEGER NOT NULL DEFAULT 0
) STRICT;
CREATE TABLE frames (
  flight_id TEXT NOT NULL REFERENCES flights (id) ON DELETE CASCADE,
  sequence INTEGER NOT NULL,
  id TEXT NOT NULL,
  sha256 TEXT NOT NULL,
  meta_json TEXT NOT NULL,
  state INTEGER NOT NULL,
  reason TEXT NOT NULL,
  is_from_batch INTEGER NOT NULL,
  tags_json TEXT NOT NULL DEFAULT '{}',
  resolved_json TEXT NOT NULL DEFAULT '',
  PRIMARY KEY (flight_id, id)
) STRICT, WITHOUT ROWID;
CREATE UNIQUE INDEX frames_by_sequence ON frames (flight_id, sequence);
CREATE INDEX frames_by_image ON frames (sha256);
CREATE INDEX frames_queued ON frames (flight_id, sequence) WHERE state = 0;
CREATE INDEX frames_in_queue ON frames (state) WHERE state = 0 AND is_from_batch = 0;
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
CREATE TABLE jobs (
  number INTEGER PRIMARY KEY AUTOINCREMENT,
  id TEXT NOT NULL UNIQUE,
  kind TEXT NOT NULL,
  flight_id TEXT NOT NULL REFERENCES flights (id) ON DELETE CASCADE,
  state INTEGER NOT NULL,
  progress_ratio REAL NOT NULL,
  stage TEXT NOT NULL,
  detail_json TEXT NOT NULL,
  created_at_us INTEGER NOT NULL
) STRICT;
CREATE INDEX jobs_by_flight ON jobs (flight_id);
CREATE INDEX jobs_unfinished ON jobs (number) WHERE state < 2;
CREATE TABLE regions (
  flight_id TEXT NOT NULL REFERENCES flights (id) ON DELETE CASCADE,
  id INTEGER NOT NULL,
  rank INTEGER NOT NULL,
  feature_json TEXT NOT NULL,
  history_json TEXT NOT NULL,
  PRIMARY KEY (flight_id, id)
) STRICT, WITHOUT ROWID;
CREATE TABLE sites (
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
  superseded_by TEXT
    REFERENCES sites (id) ON DELETE SET NULL DEFERRABLE INITIALLY DEFERRED,
  seen_at_us INTEGER NOT NULL DEFAULT 0,
  is_evidence INTEGER NOT NULL DEFAULT 0
) STRICT;
CREATE INDEX sites_superseded ON sites (superseded_by) WHERE superseded_by IS NOT NULL;
CREATE INDEX sites_by_flight ON sites (flight_id);
CREATE INDEX sites_by_place ON sites (latitude_deg, longitude_deg);
CREATE TABLE site_maps (
  site_id TEXT PRIMARY KEY REFERENCES sites (id) ON DELETE CASCADE,
  map BLOB NOT NULL
) STRICT;
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
  number,
  west_deg, east_deg, south_deg, north_deg
);
INSERT INTO flights VALUES ('f', 'a meadow', '{"name":"a meadow"}', 'rig', '[]', '{}', 1700000000000000, 3, 0, 12.5, 0);
INSERT INTO flights VALUES ('g', 'a meadow', '{"name":"a meadow"}', '', '[]', '{}', 1700000000000000, 0, 0, NULL, 0);
INSERT INTO frames VALUES ('f', 1, 'one', 'aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa', '{}', 1, 'note', 0, '{}', '{"r":1}');
INSERT INTO frames VALUES ('f', 2, 'two', 'bbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbb', '{}', 0, '', 1, '{"a":1}', '');
INSERT INTO telemetry VALUES ('f', 0, 10, 47.0, 8.0, 400.0, 0.0);
INSERT INTO telemetry VALUES ('f', 2, 12, 1.0, 2.0, 0.0, 0.0);
INSERT INTO jobs VALUES (1, 'j', 'batch', 'f', 0, 0.0, '', '{}', 0);
INSERT INTO regions VALUES ('f', 2, 1, 'two', 'h2');
INSERT INTO regions VALUES ('f', 7, 0, 'seven', 'h7');
INSERT INTO sites VALUES ('f-r1', 'f', 3, 50.0, 8.0, '{"type":"Feature"}', '', '', 0, 1414189832612002708, 'g-r1', 0, 0);
INSERT INTO sites VALUES ('g-r1', 'g', 3, 50.0, 8.0, '{"type":"Feature"}', '', '', 0, -370816059341171220, NULL, 0, 0);
INSERT INTO sites VALUES ('f-r2', 'f', 3, 50.1, 8.0, '{"type":"Feature"}', '', '', 0, 6673044070095042330, NULL, 0, 0);
INSERT INTO site_maps VALUES ('f-r1', X'6d61700078');
INSERT INTO site_maps VALUES ('g-r1', X'6e65776572');
INSERT INTO site_numbers VALUES (1, 'f-r1', 1, 1, 300.0, 'amsl', 0.7, '{}', 7425396267856091339);
INSERT INTO site_numbers VALUES (2, 'g-r1', 1, 1, 300.0, 'amsl', 0.7, '{}', 725464493213364406);
INSERT INTO site_numbers VALUES (3, 'f-r2', 0, 0, 0.0, 'unknown', 0.0, '{}', 443849211774655275);
INSERT INTO site_boxes VALUES (1, 8.0, 8.0, 50.0, 50.0);
INSERT INTO site_boxes VALUES (2, 7.899999141693115, 8.100000381469727, 49.899993896484375, 50.100006103515625);
INSERT INTO site_boxes VALUES (3, 8.0, 8.0, 50.099998474121094, 50.100006103515625);
PRAGMA application_id = 1718383363;
PRAGMA user_version = 3;
