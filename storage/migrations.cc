#include "storage/migrations.h"

namespace freelsd {
namespace {

// The one place where JSON is read here: what is a column from version 2 on stood only in the
// sites' features. The maps' extents did not stand anywhere: a box of about 3 km is surely enough.
constexpr char kFrom1To2[] = R"sql(
CREATE TABLE site_numbers (
  number INTEGER PRIMARY KEY,
  site_id TEXT NOT NULL UNIQUE REFERENCES sites (id) ON DELETE CASCADE,
  is_recallable INTEGER NOT NULL,
  is_landable INTEGER NOT NULL,
  altitude_m REAL NOT NULL,
  altitude_datum TEXT NOT NULL,
  score REAL NOT NULL,
  aircraft_json TEXT NOT NULL
) STRICT;
CREATE VIRTUAL TABLE site_boxes USING rtree (
  number, west_deg, east_deg, south_deg, north_deg
);
CREATE TRIGGER site_boxes_follow AFTER DELETE ON site_numbers BEGIN
  DELETE FROM site_boxes WHERE number = old.number;
END;
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

}  // namespace

void Migrate(const Connection& writer, int64_t version) {
  if (version < 2) writer.Execute(kFrom1To2);
}

}  // namespace freelsd
