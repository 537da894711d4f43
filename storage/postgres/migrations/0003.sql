-- Organisations on one database. Each row of theirs names its organisation, and row-level security shows and takes only
-- rows of the one that the transaction has set: set_config('freelsd.organisation', name, true). Where none is set, there
-- are no rows. A process that serves all of them sets 'freelsd.all_organisations' to 'on' in a transaction of its own: it
-- then sees the names of organisations, which flights have work, claims and events, and nothing else.
-- The security is forced, also on the tables' owner: a later migration that changes rows has to set NO FORCE around it.

-- What the servers are after they have connected. It owns nothing.
DO $$
BEGIN
  IF NOT EXISTS (SELECT FROM pg_roles WHERE rolname = 'freelsd_app') THEN
    CREATE ROLE freelsd_app NOLOGIN;
  END IF;
EXCEPTION WHEN duplicate_object OR unique_violation THEN
  NULL;  -- Another database of the cluster has just been given it.
END $$;
DO $$
BEGIN
  IF NOT pg_has_role('freelsd_app', 'MEMBER') THEN
    EXECUTE format('GRANT freelsd_app TO %I', current_user);
  END IF;
END $$;

CREATE TABLE organisations (
  name text COLLATE "C" PRIMARY KEY,          -- [a-z0-9-]{1,64}; 'default': of tokens that name none
  shares_sites boolean NOT NULL DEFAULT false -- others may read its sites, maps and obstacles
);
INSERT INTO organisations (name) VALUES ('default');

-- What counts against the quotas of an organisation.
CREATE TABLE organisation_usage (
  organisation text COLLATE "C" PRIMARY KEY,
  num_image_bytes bigint NOT NULL,
  frame_allowance double precision NOT NULL,  -- frames that it may send at once; < 0: it has to wait
  allowed_at timestamptz NOT NULL             -- when that was so
);

-- References between rows of different organisations cannot be.
ALTER TABLE frames DROP CONSTRAINT frames_flight_id_fkey, DROP CONSTRAINT frames_stored_image_fkey;
ALTER TABLE telemetry DROP CONSTRAINT telemetry_flight_id_fkey;
ALTER TABLE jobs DROP CONSTRAINT jobs_flight_id_fkey;
ALTER TABLE regions DROP CONSTRAINT regions_flight_id_fkey;
ALTER TABLE claims DROP CONSTRAINT claims_flight_id_fkey;
ALTER TABLE site_areas DROP CONSTRAINT site_areas_site_id_fkey;
ALTER TABLE site_maps DROP CONSTRAINT site_maps_site_id_fkey;
ALTER TABLE map_areas DROP CONSTRAINT map_areas_map_id_fkey;
ALTER TABLE map_tiles DROP CONSTRAINT map_tiles_map_id_fkey;
ALTER TABLE photo_tiles DROP CONSTRAINT photo_tiles_map_id_fkey, DROP CONSTRAINT photo_tiles_sha256_fkey;
ALTER TABLE images DROP CONSTRAINT images_pkey;
ALTER TABLE obstacles DROP CONSTRAINT obstacles_pkey;
ALTER TABLE sweeps DROP CONSTRAINT sweeps_pkey;

DO $$
DECLARE
  name text;
BEGIN
  FOREACH name IN ARRAY ARRAY['flights', 'frames', 'telemetry', 'jobs', 'regions', 'sites', 'site_areas', 'site_maps',
                              'maps', 'map_numbers', 'map_areas', 'map_tiles', 'photo_tiles', 'obstacles', 'images',
                              'sweeps', 'claims', 'told_events'] LOOP
    EXECUTE format('ALTER TABLE %I ADD COLUMN organisation text COLLATE "C" NOT NULL DEFAULT ''default''', name);
    EXECUTE format('ALTER TABLE %I ALTER COLUMN organisation SET DEFAULT current_setting(''freelsd.organisation'', true)',
                   name);
  END LOOP;
END $$;
ALTER TABLE organisation_usage
  ALTER COLUMN organisation SET DEFAULT current_setting('freelsd.organisation', true);

ALTER TABLE images ADD PRIMARY KEY (organisation, sha256);
ALTER TABLE obstacles ADD PRIMARY KEY (organisation, id);
ALTER TABLE sweeps ADD PRIMARY KEY (organisation, name);
ALTER TABLE flights ADD UNIQUE (organisation, id);
ALTER TABLE sites ADD UNIQUE (organisation, id);
ALTER TABLE maps ADD UNIQUE (organisation, id);
ALTER TABLE frames
  ADD FOREIGN KEY (organisation, flight_id) REFERENCES flights (organisation, id) ON DELETE CASCADE,
  ADD FOREIGN KEY (organisation, stored_image) REFERENCES images;
ALTER TABLE telemetry
  ADD FOREIGN KEY (organisation, flight_id) REFERENCES flights (organisation, id) ON DELETE CASCADE;
ALTER TABLE jobs ADD FOREIGN KEY (organisation, flight_id) REFERENCES flights (organisation, id) ON DELETE CASCADE;
ALTER TABLE regions ADD FOREIGN KEY (organisation, flight_id) REFERENCES flights (organisation, id) ON DELETE CASCADE;
ALTER TABLE claims ADD FOREIGN KEY (organisation, flight_id) REFERENCES flights (organisation, id) ON DELETE CASCADE;
ALTER TABLE site_areas ADD FOREIGN KEY (organisation, site_id) REFERENCES sites (organisation, id) ON DELETE CASCADE;
ALTER TABLE site_maps ADD FOREIGN KEY (organisation, site_id) REFERENCES sites (organisation, id) ON DELETE CASCADE;
ALTER TABLE map_areas ADD FOREIGN KEY (organisation, map_id) REFERENCES maps (organisation, id) ON DELETE CASCADE;
ALTER TABLE map_tiles ADD FOREIGN KEY (organisation, map_id) REFERENCES maps (organisation, id) ON DELETE CASCADE;
ALTER TABLE photo_tiles
  ADD FOREIGN KEY (organisation, map_id) REFERENCES maps (organisation, id) ON DELETE CASCADE,
  ADD FOREIGN KEY (organisation, sha256) REFERENCES images;
CREATE INDEX claims_by_organisation ON claims (organisation) WHERE token IS NOT NULL;

INSERT INTO organisation_usage SELECT 'default', coalesce(sum(num_bytes), 0), 0, '-infinity' FROM images;

-- At the commit, so that the row is locked for its duration only.
CREATE FUNCTION count_image_bytes() RETURNS trigger LANGUAGE plpgsql AS $$
DECLARE
  change bigint := 0;
  whose text;
BEGIN
  IF TG_OP <> 'INSERT' THEN
    change := change - OLD.num_bytes;
    whose := OLD.organisation;
  END IF;
  IF TG_OP <> 'DELETE' THEN
    change := change + NEW.num_bytes;
    whose := NEW.organisation;
  END IF;
  IF change <> 0 THEN
    INSERT INTO organisation_usage VALUES (whose, change, 0, '-infinity') ON CONFLICT (organisation)
      DO UPDATE SET num_image_bytes = organisation_usage.num_image_bytes + excluded.num_image_bytes;
  END IF;
  RETURN NULL;
END $$;
CREATE CONSTRAINT TRIGGER images_counted AFTER INSERT OR UPDATE OF num_bytes OR DELETE ON images
  DEFERRABLE INITIALLY DEFERRED FOR EACH ROW EXECUTE FUNCTION count_image_bytes();

-- Rows of the transaction's own organisation.
DO $$
DECLARE
  name text;
BEGIN
  FOREACH name IN ARRAY ARRAY['flights', 'frames', 'telemetry', 'jobs', 'regions', 'sites', 'site_areas', 'site_maps',
                              'maps', 'map_numbers', 'map_areas', 'map_tiles', 'photo_tiles', 'obstacles', 'images',
                              'sweeps', 'claims', 'told_events', 'organisation_usage'] LOOP
    EXECUTE format('ALTER TABLE %I ENABLE ROW LEVEL SECURITY, FORCE ROW LEVEL SECURITY', name);
    EXECUTE format('CREATE POLICY own ON %I USING (organisation = current_setting(''freelsd.organisation'', true))',
                   name);
  END LOOP;
END $$;
ALTER TABLE organisations ENABLE ROW LEVEL SECURITY, FORCE ROW LEVEL SECURITY;
CREATE POLICY own ON organisations USING (name = current_setting('freelsd.organisation', true));

-- What other organisations share, to be read.
CREATE POLICY shared ON organisations FOR SELECT
  USING (shares_sites AND current_setting('freelsd.organisation', true) <> '');
DO $$
DECLARE
  name text;
BEGIN
  FOREACH name IN ARRAY ARRAY['sites', 'site_areas', 'site_maps', 'maps', 'map_areas', 'map_tiles', 'obstacles'] LOOP
    EXECUTE format('CREATE POLICY shared ON %I FOR SELECT USING (current_setting(''freelsd.organisation'', true) <> '''' '
                   'AND organisation IN (SELECT o.name FROM organisations o WHERE o.shares_sites))', name);
  END LOOP;
END $$;

-- Among organisations that share, a later flight of one supersedes sites of the others, as within one.
CREATE POLICY superseding ON sites FOR UPDATE
  USING (organisation IN (SELECT o.name FROM organisations o WHERE o.shares_sites)
         AND current_setting('freelsd.organisation', true) IN
             (SELECT o.name FROM organisations o WHERE o.shares_sites));
CREATE FUNCTION refuse_change_of_others() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  IF to_jsonb(NEW) - ARRAY['superseded_by', 'superseded_by_map', 'superseded_at_us', 'superseded_reason',
                           'superseded_detail', 'confirmed_at_us', 'is_checked', 'touchdown']
     <> to_jsonb(OLD) - ARRAY['superseded_by', 'superseded_by_map', 'superseded_at_us', 'superseded_reason',
                              'superseded_detail', 'confirmed_at_us', 'is_checked', 'touchdown'] THEN
    RAISE EXCEPTION 'a site of another organisation can only be superseded' USING ERRCODE = 'insufficient_privilege';
  END IF;
  RETURN NEW;
END $$;
CREATE TRIGGER sites_of_others BEFORE UPDATE ON sites FOR EACH ROW
  WHEN (OLD.organisation IS DISTINCT FROM current_setting('freelsd.organisation', true))
  EXECUTE FUNCTION refuse_change_of_others();

-- A process that serves all. It may lock a flight, but not change it.
CREATE POLICY process ON organisations FOR SELECT
  USING (current_setting('freelsd.all_organisations', true) = 'on');
CREATE POLICY process ON flights FOR SELECT USING (current_setting('freelsd.all_organisations', true) = 'on');
CREATE POLICY process_locks ON flights FOR UPDATE USING (current_setting('freelsd.all_organisations', true) = 'on')
  WITH CHECK (organisation = current_setting('freelsd.organisation', true));
CREATE POLICY process ON frames FOR SELECT USING (current_setting('freelsd.all_organisations', true) = 'on');
CREATE POLICY process ON jobs FOR SELECT USING (current_setting('freelsd.all_organisations', true) = 'on');
CREATE POLICY process ON claims USING (current_setting('freelsd.all_organisations', true) = 'on');
CREATE POLICY process ON told_events USING (current_setting('freelsd.all_organisations', true) = 'on');

DO $$
BEGIN
  EXECUTE format('GRANT USAGE ON SCHEMA %I TO freelsd_app', current_schema());
END $$;
GRANT SELECT, INSERT, UPDATE, DELETE ON
  flights, frames, telemetry, jobs, regions, sites, site_areas, site_maps, maps, map_numbers, map_areas, map_tiles,
  photo_tiles, obstacles, images, sweeps, claims, told_events, organisations, organisation_usage, workers TO freelsd_app;
-- Of the processes, without content.
GRANT SELECT, UPDATE ON versions, owners TO freelsd_app;
