-- The feed of changes, for servers that follow this one.

CREATE TABLE feed (
  id text NOT NULL DEFAULT replace(gen_random_uuid()::text, '-', ''), -- numbers of another feed mean something else
  forgotten_through bigint NOT NULL           -- removals up to this number may be forgotten
);
INSERT INTO feed (forgotten_through) VALUES (0);
CREATE SEQUENCE change_numbers;

-- The last change of each site, map in force and obstacle of an organisation; triggers write it.
CREATE TABLE changes (
  organisation text COLLATE "C" NOT NULL DEFAULT current_setting('freelsd.organisation', true),
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
  PRIMARY KEY (organisation, subject, id)
);
CREATE INDEX changes_removed ON changes (changed_at_us) WHERE kind >= 4;
ALTER TABLE changes ENABLE ROW LEVEL SECURITY, FORCE ROW LEVEL SECURITY;
CREATE POLICY own ON changes USING (organisation = current_setting('freelsd.organisation', true));

-- Whoever changes sites or obstacles holds the row of the sites' version until the commit: no number appears after a
-- higher one.
-- A change belongs to whoever has the thing, also if another organisation supersedes a shared site.
CREATE FUNCTION tell_change(owner text, given_subject bigint, given_id text, given_kind bigint, given_stamp_us bigint,
                            west double precision, south double precision, east double precision,
                            north double precision) RETURNS void LANGUAGE plpgsql AS $$
DECLARE
  setting text := current_setting('freelsd.organisation', true);
BEGIN
  PERFORM 1 FROM versions WHERE name = 'sites' FOR NO KEY UPDATE;
  PERFORM set_config('freelsd.organisation', owner, true);
  INSERT INTO changes AS known (organisation, subject, id, number, kind, changed_at_us, stamp_us, west_deg, south_deg,
                                east_deg, north_deg)
  VALUES (owner, given_subject, given_id, nextval('change_numbers'), given_kind,
          (extract(epoch FROM clock_timestamp()) * 1000000)::bigint, given_stamp_us,
          CASE WHEN west > east THEN -180 ELSE west END, south, CASE WHEN west > east THEN 180 ELSE east END, north)
  ON CONFLICT (organisation, subject, id) DO UPDATE SET
    number = excluded.number,
    kind = CASE WHEN excluded.kind = 0 AND known.kind < 4 THEN 1 ELSE excluded.kind END,
    changed_at_us = excluded.changed_at_us,
    stamp_us = excluded.stamp_us,
    west_deg = least(known.west_deg, excluded.west_deg),
    south_deg = least(known.south_deg, excluded.south_deg),
    east_deg = greatest(known.east_deg, excluded.east_deg),
    north_deg = greatest(known.north_deg, excluded.north_deg),
    origin = CASE WHEN known.stamp_us = excluded.stamp_us THEN known.origin ELSE '' END;
  PERFORM set_config('freelsd.organisation', coalesce(setting, ''), true);
END $$;

CREATE FUNCTION tell_site() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  IF TG_OP = 'DELETE' THEN
    PERFORM tell_change(OLD.organisation, 0, OLD.id, 4, OLD.updated_at_us, OLD.longitude_deg, OLD.latitude_deg, OLD.longitude_deg,
                        OLD.latitude_deg);
  ELSE
    PERFORM tell_change(NEW.organisation, 0, NEW.id,
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
    PERFORM tell_change(OLD.organisation, 1, OLD.id, 4, OLD.updated_at_us, OLD.west_deg, OLD.south_deg, OLD.east_deg, OLD.north_deg);
  ELSE
    PERFORM tell_change(NEW.organisation, 1, NEW.id, 0, NEW.updated_at_us, NEW.west_deg, NEW.south_deg, NEW.east_deg, NEW.north_deg);
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
    PERFORM tell_change(OLD.organisation, 2, OLD.id, CASE WHEN OLD.expires_at_us < extract(epoch FROM clock_timestamp()) * 1000000
                                        THEN 5 ELSE 4 END,
                        OLD.updated_at_us, OLD.west_deg, OLD.south_deg, OLD.east_deg, OLD.north_deg);
  ELSE
    PERFORM tell_change(NEW.organisation, 2, NEW.id, CASE WHEN TG_OP = 'INSERT' THEN 0 ELSE 1 END, NEW.updated_at_us, NEW.west_deg,
                        NEW.south_deg, NEW.east_deg, NEW.north_deg);
  END IF;
  RETURN NULL;
END $$;
CREATE TRIGGER obstacle_changes AFTER INSERT OR DELETE OR UPDATE OF feature_json ON obstacles
  FOR EACH ROW EXECUTE FUNCTION tell_obstacle();

ALTER TABLE maps NO FORCE ROW LEVEL SECURITY;
ALTER TABLE sites NO FORCE ROW LEVEL SECURITY;
ALTER TABLE obstacles NO FORCE ROW LEVEL SECURITY;
-- Everything that is stored already is told as if it had just been stored.
DO $$
DECLARE told record;
BEGIN
  FOR told IN SELECT * FROM maps WHERE is_in_force ORDER BY id LOOP
    PERFORM tell_change(told.organisation, 1, told.id, 0, told.updated_at_us, told.west_deg, told.south_deg, told.east_deg,
                        told.north_deg);
  END LOOP;
  FOR told IN SELECT organisation, id, updated_at_us, longitude_deg AS lon, latitude_deg AS lat FROM sites ORDER BY id LOOP
    PERFORM tell_change(told.organisation, 0, told.id, 0, told.updated_at_us, told.lon, told.lat, told.lon, told.lat);
  END LOOP;
  FOR told IN SELECT * FROM obstacles ORDER BY id LOOP
    PERFORM tell_change(told.organisation, 2, told.id, 0, told.updated_at_us, told.west_deg, told.south_deg, told.east_deg,
                        told.north_deg);
  END LOOP;
END $$;
ALTER TABLE maps FORCE ROW LEVEL SECURITY;
ALTER TABLE sites FORCE ROW LEVEL SECURITY;
ALTER TABLE obstacles FORCE ROW LEVEL SECURITY;

GRANT SELECT, INSERT, UPDATE, DELETE ON changes TO freelsd_app;
GRANT USAGE ON SEQUENCE change_numbers TO freelsd_app;
-- Of the processes, without content.
GRANT SELECT, UPDATE ON feed TO freelsd_app;
