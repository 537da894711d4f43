-- Where the time of the last photograph is not exact, seen_at_us is the earliest possible time (0: unknown).

ALTER TABLE sites ADD COLUMN seen_until_us bigint; -- the latest possible time; NULL: seen_at_us is exact
ALTER TABLE maps ADD COLUMN seen_until_us bigint;  -- as in sites

-- Before, an unknown time was stored as that of the evaluation.
ALTER TABLE maps NO FORCE ROW LEVEL SECURITY;
ALTER TABLE sites NO FORCE ROW LEVEL SECURITY;
UPDATE maps SET seen_until_us = updated_at_us, seen_at_us = 0 WHERE seen_at_us = updated_at_us;
UPDATE sites SET seen_until_us = updated_at_us, seen_at_us = coalesce(
  (SELECT maps.seen_at_us FROM maps WHERE maps.id = sites.map_id AND maps.seen_until_us IS NULL), 0)
  WHERE seen_at_us = updated_at_us;
UPDATE sites SET seen_until_us = NULL WHERE seen_at_us > 0 AND seen_until_us IS NOT NULL;
UPDATE sites SET is_checked = false WHERE is_checked;
ALTER TABLE maps FORCE ROW LEVEL SECURITY;
ALTER TABLE sites FORCE ROW LEVEL SECURITY;
