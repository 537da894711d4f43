-- All durable data except the image files. schema.h has the number of this schema, which user_version
-- and application_id hold: it rises with each change here. Folders of another number are refused.
-- A second file, recall.db, has the same schema and holds a second copy of the tables of sites,
-- obstacles and maps. It is read if this file is damaged.
-- Times are microseconds since 1970 (UTC). Storage does not parse the text of JSON columns.

CREATE TABLE flights (
  id TEXT PRIMARY KEY,                       -- [A-Za-z0-9._-]{1,128}
  name TEXT NOT NULL,                        -- as given by the client
  request_json TEXT NOT NULL,                -- POST /v1/flights, canonical form
  rig_json TEXT NOT NULL,                    -- camera, body_from_camera, origin, told datum; '' until known
  warnings_json TEXT NOT NULL,               -- array of sentences
  stages_json TEXT NOT NULL,                 -- per stage: mean_ms, count
  created_at_us INTEGER NOT NULL,            -- microseconds since 1970
  num_rejected_frames INTEGER NOT NULL,      -- refused images of batches and streams; they have no row
  has_failed INTEGER NOT NULL,               -- 1: the engine failed on this flight; see warnings
  ground_altitude_m REAL,                    -- of the ground below the first frame, flight's datum; NULL: unknown
  has_retired_images INTEGER NOT NULL        -- 1: its images were removed to free disk space
) STRICT;

CREATE TABLE frames (
  flight_id TEXT NOT NULL REFERENCES flights (id) ON DELETE CASCADE,
  sequence INTEGER NOT NULL,                 -- order of processing within the flight, from 1
  id TEXT NOT NULL,                          -- unique within the flight
  sha256 TEXT NOT NULL,                      -- of the image file, lower-case hex; also the file's name
  meta_json TEXT NOT NULL,                   -- sent by the client: timestamp_us, position (deg, m), attitude, wind (mps)
  state INTEGER NOT NULL,                    -- 0 queued, 1 processed, 2 rejected by the frontend
  reason TEXT NOT NULL,                      -- why rejected, or a note; '' for none
  is_from_batch INTEGER NOT NULL,            -- 1: does not count against the limit of the frame queue
  tags_json TEXT NOT NULL,                   -- the same keys, from the image's own tags
  resolved_json TEXT NOT NULL,               -- the same keys, as the engine uses them; '' until settled
  arrived_at_us INTEGER NOT NULL,            -- as in telemetry
  PRIMARY KEY (flight_id, id)
) STRICT, WITHOUT ROWID;
CREATE UNIQUE INDEX frames_by_sequence ON frames (flight_id, sequence);
CREATE INDEX frames_by_image ON frames (sha256);
CREATE INDEX frames_queued ON frames (flight_id, sequence) WHERE state = 0;
CREATE INDEX frames_in_queue ON frames (state) WHERE state = 0 AND is_from_batch = 0;

-- Position, attitude and wind that the aircraft reports between frames. Of a flight's frames and
-- telemetry, what arrived later has the higher arrived_at_us, also if the clock was set back.
CREATE TABLE telemetry (
  flight_id TEXT NOT NULL REFERENCES flights (id) ON DELETE CASCADE,
  kind INTEGER NOT NULL,                     -- 0 position (deg, deg, m), 1 attitude (w, x, y, z), 2 wind (mps)
  timestamp_us INTEGER NOT NULL,             -- microseconds since 1970
  value_0 REAL NOT NULL,                     -- latitude_deg | w | east_mps
  value_1 REAL NOT NULL,                     -- longitude_deg | x | north_mps
  value_2 REAL NOT NULL,                     -- altitude_m | y | deviation of the wind, mps; 0 unknown
  value_3 REAL NOT NULL,                     -- datum: 0 not told, 1 amsl, 2 ellipsoid | z | source: 0 not told, 1 autopilot, 2 drift
  arrived_at_us INTEGER NOT NULL,            -- when the server received it
  PRIMARY KEY (flight_id, kind, timestamp_us)
) STRICT, WITHOUT ROWID;
CREATE INDEX telemetry_by_arrival ON telemetry (flight_id, kind, arrived_at_us);

CREATE TABLE jobs (
  number INTEGER PRIMARY KEY AUTOINCREMENT,  -- order of arrival
  id TEXT NOT NULL UNIQUE,
  kind TEXT NOT NULL,                        -- 'batch' or 'finish'
  flight_id TEXT NOT NULL REFERENCES flights (id) ON DELETE CASCADE,
  state INTEGER NOT NULL,                    -- 0 queued, 1 running, 2 done, 3 failed, 4 cancelled
  progress_ratio REAL NOT NULL,              -- 0..1
  stage TEXT NOT NULL,                       -- name of the current step
  detail_json TEXT NOT NULL,                 -- verdict of each image, message of a failure
  created_at_us INTEGER NOT NULL             -- microseconds since 1970
) STRICT;
CREATE INDEX jobs_by_flight ON jobs (flight_id);
CREATE INDEX jobs_unfinished ON jobs (number) WHERE state < 2;

CREATE TABLE regions (
  flight_id TEXT NOT NULL REFERENCES flights (id) ON DELETE CASCADE,
  id INTEGER NOT NULL,                       -- stable within the flight
  rank INTEGER NOT NULL,                     -- order of the snapshot, best first, from 0
  feature_json TEXT NOT NULL,                -- GeoJSON feature (deg, m2)
  history_json TEXT NOT NULL,                -- grade and counts per frame
  PRIMARY KEY (flight_id, id)
) STRICT, WITHOUT ROWID;

-- A site stays when its flight is deleted, so there is no foreign key to flights.
CREATE TABLE sites (
  id TEXT PRIMARY KEY,                       -- '<flight>-r<region>'; a further field of the region '…-f<number>'
  flight_id TEXT NOT NULL,
  region_id INTEGER NOT NULL,
  latitude_deg REAL NOT NULL,                -- touchdown, WGS84 degrees
  longitude_deg REAL NOT NULL,               -- touchdown, WGS84 degrees
  feature_json TEXT NOT NULL,                -- GeoJSON feature without rank
  approach_json TEXT NOT NULL,               -- FeatureCollection; '' where there is no approach
  replan_json TEXT NOT NULL,                 -- region, aircraft, origin, datum
  updated_at_us INTEGER NOT NULL,            -- microseconds since 1970
  checksum INTEGER,                          -- of the row; NULL: not computed, in a bench that writes rows itself
  superseded_by TEXT,                        -- id of the site on whose later map the stored plan fails, else of the flight
  seen_at_us INTEGER NOT NULL,               -- when the ground of its map was last photographed, microseconds since 1970; 0: unknown
  superseded_at_us INTEGER,                  -- when the ground of superseded_by was photographed; NULL: not superseded, or order unknown
  superseded_reason TEXT NOT NULL DEFAULT '',  -- the rule that the plan breaks there, as reject_reason; '' for none; if superseded_by is NULL: a doubt
  superseded_detail TEXT NOT NULL DEFAULT '',  -- a sentence with numbers; '' for none
  confirmed_at_us INTEGER,                   -- when the ground was photographed of the last later map where the plan holds
  map_id TEXT NOT NULL,                      -- of maps; '': nothing was reconstructed
  superseded_by_map TEXT NOT NULL DEFAULT '',  -- the later map, or the one that doubts; '' for none
  seen_until_us INTEGER                      -- latest possible time, where seen_at_us is the earliest; NULL: seen_at_us is exact
) STRICT;
CREATE INDEX sites_by_map ON sites (map_id) WHERE map_id <> '';
CREATE INDEX sites_superseded_by_map ON sites (superseded_by_map) WHERE superseded_by_map <> '';
CREATE INDEX sites_superseded ON sites (superseded_by) WHERE superseded_by IS NOT NULL;
CREATE INDEX sites_confirmed ON sites (confirmed_at_us) WHERE confirmed_at_us IS NOT NULL;
CREATE INDEX sites_by_flight ON sites (flight_id);
CREATE INDEX sites_by_place ON sites (latitude_deg, longitude_deg);

-- The columns of a site that emergency recall reads, by number: an R*Tree needs integer keys.
CREATE TABLE site_numbers (
  number INTEGER PRIMARY KEY,
  site_id TEXT NOT NULL UNIQUE REFERENCES sites (id) ON DELETE CASCADE,
  is_recallable INTEGER NOT NULL,            -- 0: rejected, or without terrain; its map still counts as terrain
  is_landable INTEGER NOT NULL,              -- 1 landable, 0 unverified
  altitude_m REAL NOT NULL,                  -- of the touchdown, in altitude_datum
  altitude_datum TEXT NOT NULL,              -- 'amsl', 'ellipsoid' or 'unknown'; also of the map
  score REAL NOT NULL,                       -- 0..1, when the site was stored
  aircraft_json TEXT NOT NULL,               -- the aircraft for which the site was planned
  checksum INTEGER                           -- of the row and the site's position; NULL: not computed, in a bench that writes rows itself
) STRICT;
CREATE INDEX site_numbers_by_altitude ON site_numbers (altitude_m) WHERE is_recallable = 1;
CREATE INDEX site_numbers_by_aircraft ON site_numbers (aircraft_json) WHERE is_recallable = 1;
CREATE VIRTUAL TABLE site_boxes USING rtree (
  number,                                    -- of site_numbers
  -- WGS84: area of the site's map, touchdown included. Across the antimeridian, east_deg > 180.
  west_deg, east_deg, south_deg, north_deg
);

-- A map of a flight. It stays when the flight is deleted, so there is no foreign key to flights.
CREATE TABLE maps (
  id TEXT PRIMARY KEY,                       -- '<flight>/<number>'
  flight_id TEXT NOT NULL,
  number INTEGER NOT NULL,                   -- within the flight; a later map has a higher one
  head_json TEXT NOT NULL,                   -- grid, origin, photographs, deviations, quality
  altitude_datum TEXT NOT NULL,              -- 'amsl', 'ellipsoid' or 'unknown'
  west_deg REAL NOT NULL,                    -- WGS84 box of its grid; west > east crosses the antimeridian
  south_deg REAL NOT NULL,                   -- WGS84 degrees
  east_deg REAL NOT NULL,                    -- WGS84 degrees
  north_deg REAL NOT NULL,                   -- WGS84 degrees
  updated_at_us INTEGER NOT NULL,            -- microseconds since 1970
  seen_at_us INTEGER NOT NULL,               -- when the ground was last photographed, microseconds since 1970; 0: unknown
  is_in_force INTEGER NOT NULL,              -- 0: an unfinished evaluation writes it
  checksum INTEGER NOT NULL,                 -- of the row without is_in_force
  seen_until_us INTEGER                      -- as in sites
) STRICT;
CREATE UNIQUE INDEX maps_by_flight ON maps (flight_id, number);
CREATE INDEX maps_by_latitude ON maps (south_deg, north_deg) WHERE is_in_force = 1;

CREATE TABLE map_tiles (
  map_id TEXT NOT NULL REFERENCES maps (id) ON DELETE CASCADE,
  level INTEGER NOT NULL,                    -- cells are 2^level cells of the map wide
  row INTEGER NOT NULL,                      -- from the world's origin to the south
  col INTEGER NOT NULL,                      -- from the world's origin to the east
  tile BLOB NOT NULL,                        -- compressed layers (m, rad, 0..1), versioned inside
  PRIMARY KEY (map_id, level, row, col)
) STRICT;

CREATE TABLE photo_tiles (
  map_id TEXT NOT NULL REFERENCES maps (id) ON DELETE CASCADE,
  level INTEGER NOT NULL,                    -- pixels are 2^level pixels of level 0 wide
  row INTEGER NOT NULL,                      -- from the world's origin to the south
  col INTEGER NOT NULL,                      -- from the world's origin to the east
  sha256 TEXT NOT NULL,                      -- of the image file, lower-case hex; also the file's name
  PRIMARY KEY (map_id, level, row, col)
) STRICT, WITHOUT ROWID;
CREATE INDEX photo_tiles_by_image ON photo_tiles (sha256);

-- What photographs do not show: wires, masts, airspaces, people.
CREATE TABLE obstacles (
  id TEXT PRIMARY KEY,                       -- [A-Za-z0-9._-]{1,128}
  feature_json TEXT NOT NULL,                -- GeoJSON feature (deg, m), canonical form
  west_deg REAL NOT NULL,                    -- WGS84 box of its geometry; never crosses the antimeridian
  south_deg REAL NOT NULL,                   -- WGS84 degrees
  east_deg REAL NOT NULL,                    -- WGS84 degrees
  north_deg REAL NOT NULL,                   -- WGS84 degrees
  expires_at_us INTEGER,                     -- microseconds since 1970; it counts no longer then; NULL: never
  updated_at_us INTEGER NOT NULL,            -- microseconds since 1970
  checksum INTEGER NOT NULL                  -- of the row
) STRICT;

-- The feed of changes. One row; none in the second copy, which keeps no changes.
CREATE TABLE feed (
  id TEXT NOT NULL,                          -- random; numbers of another feed mean something else
  number INTEGER NOT NULL,                   -- of the last change
  forgotten_through INTEGER NOT NULL,        -- removals up to this number may be forgotten
  is_from_above INTEGER NOT NULL             -- 1 within a commit of what the followed server told
) STRICT;
INSERT INTO feed VALUES (lower(hex(randomblob(8))), 0, 0, 0);

-- The last change of each site, map in force and obstacle; triggers write it.
CREATE TABLE changes (
  subject INTEGER NOT NULL,                  -- 0 site, 1 map, 2 obstacle
  id TEXT NOT NULL,                          -- of the site, map or obstacle
  number INTEGER NOT NULL UNIQUE,            -- increases with every change of anything
  kind INTEGER NOT NULL,                     -- 0 stored, 1 updated, 2 superseded, 3 confirmed, 4 removed, 5 expired
  changed_at_us INTEGER NOT NULL,            -- microseconds since 1970
  stamp_us INTEGER NOT NULL,                 -- updated_at_us of the row, or of the removed row
  west_deg REAL NOT NULL,                    -- WGS84 box of where it is, and was; never crosses the antimeridian
  south_deg REAL NOT NULL,                   -- WGS84 degrees
  east_deg REAL NOT NULL,                    -- WGS84 degrees
  north_deg REAL NOT NULL,                   -- WGS84 degrees
  origin TEXT NOT NULL DEFAULT '',           -- feed of the server that has made it; '': this one's
  is_known_above INTEGER NOT NULL,           -- 1: the followed server has it as it is
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

-- What a follower keeps of the server that it follows. In the second copy: the id of the feed of the
-- database that it follows, the number of the last change that it has, and when it was written.
CREATE TABLE follow_state (
  followed TEXT PRIMARY KEY,                 -- address and area
  next TEXT NOT NULL,                        -- where to go on in its feed; '': from the beginning
  in_step_at_us INTEGER                      -- when this copy was last in step, microseconds since 1970; NULL: never
) STRICT;
