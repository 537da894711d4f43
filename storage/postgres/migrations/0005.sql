-- Which aircraft have sites is found by one search for each, not by reading all sites.

CREATE INDEX sites_by_aircraft ON sites (aircraft_json COLLATE "C") WHERE is_recallable;
