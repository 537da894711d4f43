-- The lowest and the kinds of sites, and the latest change, are found for each organisation by its own entries: beside
-- one with many sites, another one's were found by reading all of them.

DROP INDEX sites_by_altitude;
CREATE INDEX sites_by_altitude ON sites (organisation, altitude_m) WHERE is_recallable;
DROP INDEX sites_by_aircraft;
CREATE INDEX sites_by_aircraft ON sites (organisation, (aircraft_json COLLATE "C")) WHERE is_recallable;
CREATE INDEX changes_by_organisation ON changes (organisation, number);

ALTER TABLE organisations
  ADD COLUMN has_unchecked_ground boolean NOT NULL DEFAULT false; -- it shares, and others' sites there are not yet marked
