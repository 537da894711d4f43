-- All durable data except the image files. Whoever changes a table raises the schema's number (schema.cc).
-- Times are microseconds since 1970 (UTC), but for timestamptz, which is the database's own clock.
-- Text is compared byte by byte (COLLATE "C"). Storage does not parse the text of *_json columns.
-- Places are found by geometry; the degrees beside it are exact.

CREATE EXTENSION IF NOT EXISTS postgis;

-- The number of this schema (schema.cc), in one row. Databases of another number are refused.
CREATE TABLE schema_migrations (version bigint PRIMARY KEY);

-- Increases with every commit that changes a site or obstacle, or tells an event. Its row lock makes
-- the writers take turns, so a reader that saw a value sees all changes up to it.
CREATE TABLE versions (
  name text COLLATE "C" PRIMARY KEY,          -- 'sites', 'obstacles' or 'events'
  value bigint NOT NULL
);
INSERT INTO versions VALUES ('sites', 1), ('obstacles', 1), ('events', 0);

-- The process that has the database for itself: it has the token that it put here. Its writes hold
-- the row, so whoever takes the database waits for them, and later ones are refused.
CREATE TABLE owners (
  is_only boolean PRIMARY KEY DEFAULT true CHECK (is_only),
  token bigint NOT NULL,
  is_alone boolean NOT NULL DEFAULT true
);
INSERT INTO owners (token) VALUES (0);

-- When images that nothing refers to were last looked for. One process at a time does.
CREATE TABLE sweeps (
  name text COLLATE "C" PRIMARY KEY,
  swept_at timestamptz NOT NULL
);
INSERT INTO sweeps VALUES ('images', '-infinity');

-- The lock of a row guards the file of that name: it is written and removed under it.
CREATE TABLE images (
  sha256 text COLLATE "C" PRIMARY KEY,        -- lower-case hex; also the file's name
  num_bytes bigint NOT NULL,
  written_at timestamptz NOT NULL DEFAULT now()
);

CREATE TABLE flights (
  number bigint GENERATED ALWAYS AS IDENTITY UNIQUE,  -- order of creation
  id text COLLATE "C" PRIMARY KEY,            -- [A-Za-z0-9._-]{1,128}
  name text NOT NULL,                         -- as given by the client
  request_json text NOT NULL,                 -- POST /v1/flights, canonical form
  rig_json text NOT NULL,                     -- camera, body_from_camera, origin, datum; '' until known
  warnings_json text NOT NULL,                -- array of sentences
  stages_json text NOT NULL,                  -- per stage: mean_ms, count
  created_at_us bigint NOT NULL,
  num_rejected_frames bigint NOT NULL,        -- refused images of batches and streams; they have no row
  has_failed boolean NOT NULL,                -- the engine failed on this flight; see warnings
  ground_altitude_m double precision,         -- of the ground below the first frame, flight's datum
  has_retired_images boolean NOT NULL         -- its images were removed to free disk space
);
CREATE INDEX flights_by_creation ON flights (created_at_us, id);

CREATE TABLE frames (
  flight_id text COLLATE "C" NOT NULL REFERENCES flights ON DELETE CASCADE,
  sequence bigint NOT NULL,                   -- order of processing within the flight, from 1
  id text COLLATE "C" NOT NULL,               -- unique within the flight
  sha256 text COLLATE "C" NOT NULL,           -- of the image
  stored_image text COLLATE "C" REFERENCES images,  -- the same; NULL: the image was removed to free space
  meta_json text NOT NULL,                    -- sent by the client
  state smallint NOT NULL,                    -- 0 queued, 1 processed, 2 rejected by the frontend
  reason text NOT NULL,                       -- why rejected, or a note; '' for none
  is_from_batch boolean NOT NULL,             -- does not count against the limit of the frame queue
  tags_json text NOT NULL,                    -- the same keys, from the image's own tags
  resolved_json text NOT NULL,                -- the same keys, as the engine uses them; '' until settled
  arrived_at_us bigint NOT NULL,              -- as in telemetry
  PRIMARY KEY (flight_id, id),
  UNIQUE (flight_id, sequence)
);
CREATE INDEX frames_by_image ON frames (stored_image) WHERE stored_image IS NOT NULL;
CREATE INDEX frames_queued ON frames (flight_id, sequence) WHERE state = 0;
CREATE INDEX frames_in_queue ON frames (state) WHERE state = 0 AND NOT is_from_batch;

-- What arrived later has the higher arrived_at_us, also if a clock was set back.
CREATE TABLE telemetry (
  flight_id text COLLATE "C" NOT NULL REFERENCES flights ON DELETE CASCADE,
  kind smallint NOT NULL,                     -- 0 position (deg, deg, m), 1 attitude (w, x, y, z), 2 wind (mps)
  timestamp_us bigint NOT NULL,
  value_0 double precision NOT NULL,          -- latitude_deg | w | east_mps
  value_1 double precision NOT NULL,          -- longitude_deg | x | north_mps
  value_2 double precision NOT NULL,          -- altitude_m | y | deviation of the wind, mps; 0 unknown
  value_3 double precision NOT NULL,          -- datum: 0 not told, 1 amsl, 2 ellipsoid | z | source: 0 not told, 1 autopilot, 2 drift
  arrived_at_us bigint NOT NULL,              -- when a server received it; <= 0: an order only
  PRIMARY KEY (flight_id, kind, timestamp_us)
);
CREATE INDEX telemetry_by_arrival ON telemetry (flight_id, kind, arrived_at_us);

CREATE TABLE jobs (
  number bigint GENERATED ALWAYS AS IDENTITY PRIMARY KEY,  -- order of arrival
  id text COLLATE "C" NOT NULL UNIQUE,
  kind text NOT NULL,                         -- 'batch', 'finish' or 'replay'
  flight_id text COLLATE "C" NOT NULL REFERENCES flights ON DELETE CASCADE,
  state smallint NOT NULL,                    -- 0 queued, 1 running, 2 done, 3 failed, 4 cancelled
  progress_ratio double precision NOT NULL,   -- 0..1
  stage text NOT NULL,                        -- name of the current step
  detail_json text NOT NULL,                  -- verdict of each image, message of a failure
  created_at_us bigint NOT NULL
);
CREATE INDEX jobs_by_flight ON jobs (flight_id);
CREATE INDEX jobs_unfinished ON jobs (number) WHERE state < 2;

CREATE TABLE regions (
  flight_id text COLLATE "C" NOT NULL REFERENCES flights ON DELETE CASCADE,
  id bigint NOT NULL,                         -- stable within the flight
  rank bigint NOT NULL,                       -- order of the snapshot, best first, from 0
  feature_json text NOT NULL,                 -- GeoJSON feature (deg, m2)
  history_json text NOT NULL,                 -- grade and counts per frame
  PRIMARY KEY (flight_id, id)
);

-- A site stays when its flight is deleted, so there is no foreign key to flights.
CREATE TABLE sites (
  id text COLLATE "C" PRIMARY KEY,
  flight_id text COLLATE "C" NOT NULL,
  region_id bigint NOT NULL,
  map_id text COLLATE "C" NOT NULL,           -- of maps; '': nothing was reconstructed
  latitude_deg double precision NOT NULL,     -- touchdown, WGS84
  longitude_deg double precision NOT NULL,    -- touchdown, WGS84
  touchdown geometry(Point, 4326) NOT NULL
    GENERATED ALWAYS AS (ST_SetSRID(ST_MakePoint(longitude_deg, latitude_deg), 4326)) STORED,
  feature_json text NOT NULL,                 -- GeoJSON feature without rank
  approach_json text NOT NULL,                -- FeatureCollection; '' where there is no approach
  replan_json text NOT NULL,                  -- region, aircraft, origin, datum
  updated_at_us bigint NOT NULL,
  seen_at_us bigint NOT NULL,                 -- when the ground of its map was last photographed, or the
                                              -- earliest possible time where it is not exact; 0: unknown
  seen_until_us bigint,                       -- the latest possible time; NULL: seen_at_us is exact
  -- Standing on later maps (site_store.h).
  superseded_by text COLLATE "C",             -- NULL: not superseded
  superseded_by_map text COLLATE "C" NOT NULL DEFAULT '',
  superseded_at_us bigint,
  superseded_reason text NOT NULL DEFAULT '',
  superseded_detail text NOT NULL DEFAULT '',
  confirmed_at_us bigint,
  -- What recall reads.
  is_recallable boolean NOT NULL,             -- false: rejected, or without terrain
  is_landable boolean NOT NULL,               -- false: unverified
  altitude_m double precision NOT NULL,       -- of the touchdown, in altitude_datum
  altitude_datum text NOT NULL,               -- 'amsl', 'ellipsoid' or 'unknown'; also of the map
  score double precision NOT NULL,            -- 0..1, when the site was stored
  aircraft_json text NOT NULL,                -- the aircraft for which the site was planned
  west_deg double precision NOT NULL,         -- area of its map; west > east crosses the antimeridian
  south_deg double precision NOT NULL,
  east_deg double precision NOT NULL,
  north_deg double precision NOT NULL
);
CREATE INDEX sites_by_flight ON sites (flight_id);
CREATE INDEX sites_by_place ON sites USING gist (touchdown);
CREATE INDEX sites_superseded ON sites (superseded_by) WHERE superseded_by IS NOT NULL;
CREATE INDEX sites_superseded_by_map ON sites (superseded_by_map) WHERE superseded_by_map <> '';
CREATE INDEX sites_confirmed ON sites (confirmed_at_us) WHERE confirmed_at_us IS NOT NULL;
CREATE INDEX sites_by_altitude ON sites (altitude_m) WHERE is_recallable;
-- Which aircraft have sites is found by one search for each, not by reading all sites.
CREATE INDEX sites_by_aircraft ON sites (aircraft_json COLLATE "C") WHERE is_recallable;

-- The area of a site's map, or its touchdown: one box, or two at the antimeridian.
CREATE TABLE site_areas (
  site_id text COLLATE "C" NOT NULL REFERENCES sites ON DELETE CASCADE,
  part bigint NOT NULL,
  area geometry(Polygon, 4326) NOT NULL,
  PRIMARY KEY (site_id, part)
);
CREATE INDEX site_areas_by_place ON site_areas USING gist (area);

-- A map of a flight. It stays when the flight is deleted, so there is no foreign key to flights.
CREATE TABLE maps (
  id text COLLATE "C" PRIMARY KEY,            -- '<flight>/<number>'
  flight_id text COLLATE "C" NOT NULL,
  number bigint NOT NULL,                     -- within the flight; a later map has a higher one
  head_json text NOT NULL,                    -- grid, origin, photographs, deviations, quality
  altitude_datum text NOT NULL,               -- 'amsl', 'ellipsoid' or 'unknown'
  west_deg double precision NOT NULL,         -- WGS84 box of its grid; west > east crosses the antimeridian
  south_deg double precision NOT NULL,
  east_deg double precision NOT NULL,
  north_deg double precision NOT NULL,
  updated_at_us bigint NOT NULL,
  seen_at_us bigint NOT NULL,                 -- when the ground was last photographed, as in sites
  seen_until_us bigint,                       -- as in sites
  is_in_force boolean NOT NULL,               -- false: an unfinished evaluation writes it
  staged_at timestamptz NOT NULL DEFAULT now(),
  UNIQUE (flight_id, number)
);
CREATE INDEX maps_unfinished ON maps (staged_at) WHERE NOT is_in_force;

-- The last number that was given to a map of the flight, stored or not.
CREATE TABLE map_numbers (
  flight_id text COLLATE "C" PRIMARY KEY,
  last bigint NOT NULL
);

CREATE TABLE map_areas (
  map_id text COLLATE "C" NOT NULL REFERENCES maps ON DELETE CASCADE,
  part bigint NOT NULL,
  area geometry(Polygon, 4326) NOT NULL,
  PRIMARY KEY (map_id, part)
);
CREATE INDEX map_areas_by_place ON map_areas USING gist (area);

CREATE TABLE map_tiles (
  map_id text COLLATE "C" NOT NULL REFERENCES maps ON DELETE CASCADE,
  level bigint NOT NULL,                      -- cells are 2^level cells of the map wide
  row bigint NOT NULL,                        -- from the world's origin to the south
  col bigint NOT NULL,                        -- from the world's origin to the east
  tile bytea NOT NULL,                        -- compressed layers (m, rad, 0..1), versioned inside
  PRIMARY KEY (map_id, level, row, col)
);
ALTER TABLE map_tiles ALTER COLUMN tile SET STORAGE EXTERNAL;

CREATE TABLE photo_tiles (
  map_id text COLLATE "C" NOT NULL REFERENCES maps ON DELETE CASCADE,
  level bigint NOT NULL,                      -- pixels are 2^level pixels of level 0 wide
  row bigint NOT NULL,                        -- from the world's origin to the south
  col bigint NOT NULL,                        -- from the world's origin to the east
  sha256 text COLLATE "C" NOT NULL REFERENCES images,
  PRIMARY KEY (map_id, level, row, col)
);
CREATE INDEX photo_tiles_by_image ON photo_tiles (sha256);

-- What photographs do not show: wires, masts, airspaces, people.
CREATE TABLE obstacles (
  id text COLLATE "C" PRIMARY KEY,            -- [A-Za-z0-9._-]{1,128}
  feature_json text NOT NULL,                 -- GeoJSON feature (deg, m), canonical form
  west_deg double precision NOT NULL,         -- WGS84 box of its geometry
  south_deg double precision NOT NULL,
  east_deg double precision NOT NULL,
  north_deg double precision NOT NULL,
  area geometry(Polygon, 4326) NOT NULL
    GENERATED ALWAYS AS (ST_MakeEnvelope(west_deg, south_deg, east_deg, north_deg, 4326)) STORED,
  expires_at_us bigint,                       -- it counts no longer then; NULL: never
  updated_at_us bigint NOT NULL,
  CHECK (west_deg <= east_deg AND south_deg <= north_deg)
);
CREATE INDEX obstacles_by_place ON obstacles USING gist (area);
CREATE INDEX obstacles_expiring ON obstacles (expires_at_us) WHERE expires_at_us IS NOT NULL;

-- Several processes on one database: who works on which flight, and what they tell each other.

-- A process that works on flights. Its writes hold the row (FOR KEY SHARE), so that whoever deletes
-- it waits for them, and later ones are refused.
CREATE TABLE workers (
  token bigint GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
  expires_at timestamptz NOT NULL             -- end of its lease
);

CREATE TABLE claims (
  flight_id text COLLATE "C" PRIMARY KEY REFERENCES flights ON DELETE CASCADE,
  token bigint REFERENCES workers,            -- NULL: nobody works on it
  num_lost bigint NOT NULL DEFAULT 0          -- workers in a row that ended without a word
);
CREATE INDEX claims_by_worker ON claims (token) WHERE token IS NOT NULL;

-- Events that processes tell each other. The row of versions orders their numbers by commit.
CREATE TABLE told_events (
  number bigint PRIMARY KEY,
  origin text COLLATE "C" NOT NULL,           -- the process that tells
  type text NOT NULL,
  flight_id text COLLATE "C" NOT NULL,
  data text NOT NULL,                         -- JSON
  told_at timestamptz NOT NULL DEFAULT now()
);
CREATE INDEX told_events_by_time ON told_events (told_at);

-- The feed of changes, for servers that follow this one.

CREATE TABLE feed (
  id text NOT NULL DEFAULT replace(gen_random_uuid()::text, '-', ''), -- numbers of another feed mean something else
  forgotten_through bigint NOT NULL           -- removals up to this number may be forgotten
);
INSERT INTO feed (forgotten_through) VALUES (0);
CREATE SEQUENCE change_numbers;

-- The last change of each site, map in force and obstacle; triggers write it.
CREATE TABLE changes (
  subject bigint NOT NULL,                    -- 0 site, 1 map, 2 obstacle
  id text COLLATE "C" NOT NULL,               -- of the site, map or obstacle
  number bigint NOT NULL UNIQUE,              -- increases with every change of anything
  kind bigint NOT NULL,                       -- 0 stored, 1 updated, 2 superseded, 3 confirmed, 4 removed, 5 expired
  changed_at_us bigint NOT NULL,
  stamp_us bigint NOT NULL,                   -- updated_at_us of the row, or of the removed row
  west_deg double precision NOT NULL,         -- box of where it is, and was; never crosses the antimeridian
  south_deg double precision NOT NULL,
  east_deg double precision NOT NULL,
  north_deg double precision NOT NULL,
  origin text COLLATE "C" NOT NULL DEFAULT '', -- feed of the server that has made it; '': this one's
  PRIMARY KEY (subject, id)
);
CREATE INDEX changes_removed ON changes (changed_at_us) WHERE kind >= 4;

-- Whoever changes sites or obstacles holds the row of the sites' version until the commit: no number appears after a
-- higher one.
CREATE FUNCTION tell_change(given_subject bigint, given_id text, given_kind bigint, given_stamp_us bigint,
                            west double precision, south double precision, east double precision,
                            north double precision) RETURNS void LANGUAGE plpgsql AS $$
BEGIN
  PERFORM 1 FROM versions WHERE name = 'sites' FOR NO KEY UPDATE;
  INSERT INTO changes AS known (subject, id, number, kind, changed_at_us, stamp_us, west_deg, south_deg, east_deg,
                                north_deg)
  VALUES (given_subject, given_id, nextval('change_numbers'), given_kind,
          (extract(epoch FROM clock_timestamp()) * 1000000)::bigint, given_stamp_us,
          CASE WHEN west > east THEN -180 ELSE west END, south, CASE WHEN west > east THEN 180 ELSE east END, north)
  ON CONFLICT (subject, id) DO UPDATE SET
    number = excluded.number,
    kind = CASE WHEN excluded.kind = 0 AND known.kind < 4 THEN 1 ELSE excluded.kind END,
    changed_at_us = excluded.changed_at_us,
    stamp_us = excluded.stamp_us,
    west_deg = least(known.west_deg, excluded.west_deg),
    south_deg = least(known.south_deg, excluded.south_deg),
    east_deg = greatest(known.east_deg, excluded.east_deg),
    north_deg = greatest(known.north_deg, excluded.north_deg),
    origin = CASE WHEN known.stamp_us = excluded.stamp_us THEN known.origin ELSE '' END;
END $$;

CREATE FUNCTION tell_site() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  IF TG_OP = 'DELETE' THEN
    PERFORM tell_change(0, OLD.id, 4, OLD.updated_at_us, OLD.longitude_deg, OLD.latitude_deg, OLD.longitude_deg,
                        OLD.latitude_deg);
  ELSE
    PERFORM tell_change(0, NEW.id,
                        CASE WHEN TG_ARGV[0] <> 'standing' THEN TG_ARGV[0]::bigint
                             WHEN NEW.superseded_by IS NOT NULL THEN 2
                             WHEN NEW.confirmed_at_us IS DISTINCT FROM OLD.confirmed_at_us THEN 3 ELSE 1 END,
                        NEW.updated_at_us, NEW.longitude_deg, NEW.latitude_deg, NEW.longitude_deg, NEW.latitude_deg);
  END IF;
  RETURN NULL;
END $$;
CREATE TRIGGER site_is_stored AFTER INSERT ON sites FOR EACH ROW EXECUTE FUNCTION tell_site('0');
CREATE TRIGGER site_is_updated AFTER UPDATE OF feature_json ON sites FOR EACH ROW EXECUTE FUNCTION tell_site('1');
CREATE TRIGGER site_stands_otherwise AFTER UPDATE OF superseded_by ON sites FOR EACH ROW
  WHEN ((NEW.superseded_by, NEW.superseded_by_map, NEW.superseded_at_us, NEW.superseded_reason, NEW.superseded_detail,
         NEW.confirmed_at_us) IS DISTINCT FROM
        (OLD.superseded_by, OLD.superseded_by_map, OLD.superseded_at_us, OLD.superseded_reason, OLD.superseded_detail,
         OLD.confirmed_at_us))
  EXECUTE FUNCTION tell_site('standing');
CREATE TRIGGER site_is_removed AFTER DELETE ON sites FOR EACH ROW EXECUTE FUNCTION tell_site('4');

CREATE FUNCTION tell_map() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  IF TG_OP = 'DELETE' THEN
    PERFORM tell_change(1, OLD.id, 4, OLD.updated_at_us, OLD.west_deg, OLD.south_deg, OLD.east_deg, OLD.north_deg);
  ELSE
    PERFORM tell_change(1, NEW.id, 0, NEW.updated_at_us, NEW.west_deg, NEW.south_deg, NEW.east_deg, NEW.north_deg);
  END IF;
  RETURN NULL;
END $$;
CREATE TRIGGER map_is_stored AFTER INSERT ON maps FOR EACH ROW WHEN (NEW.is_in_force) EXECUTE FUNCTION tell_map();
CREATE TRIGGER map_comes_in_force AFTER UPDATE OF is_in_force ON maps FOR EACH ROW
  WHEN (NEW.is_in_force AND NOT OLD.is_in_force) EXECUTE FUNCTION tell_map();
CREATE TRIGGER map_is_removed AFTER DELETE ON maps FOR EACH ROW WHEN (OLD.is_in_force) EXECUTE FUNCTION tell_map();

CREATE FUNCTION tell_obstacle() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  IF TG_OP = 'DELETE' THEN
    PERFORM tell_change(2, OLD.id, CASE WHEN OLD.expires_at_us < extract(epoch FROM clock_timestamp()) * 1000000
                                        THEN 5 ELSE 4 END,
                        OLD.updated_at_us, OLD.west_deg, OLD.south_deg, OLD.east_deg, OLD.north_deg);
  ELSE
    PERFORM tell_change(2, NEW.id, CASE WHEN TG_OP = 'INSERT' THEN 0 ELSE 1 END, NEW.updated_at_us, NEW.west_deg,
                        NEW.south_deg, NEW.east_deg, NEW.north_deg);
  END IF;
  RETURN NULL;
END $$;
CREATE TRIGGER obstacle_changes AFTER INSERT OR DELETE OR UPDATE OF feature_json ON obstacles
  FOR EACH ROW EXECUTE FUNCTION tell_obstacle();
