-- Where the time of the last photograph is not exact, seen_at_us is the earliest possible time (0: unknown).

ALTER TABLE sites ADD COLUMN seen_until_us bigint; -- the latest possible time; NULL: seen_at_us is exact
ALTER TABLE maps ADD COLUMN seen_until_us bigint;  -- as in sites
