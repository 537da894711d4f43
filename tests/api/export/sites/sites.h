// Sites whose truth is known, as they are stored.
#pragma once

#include "api/api.h"
#include "api/export/sites/sites.h"

namespace freelsd {

struct KnownSite {
  // As in the row of the site; the rank is added, as answers have it.
  std::string feature_json;
  std::string approach_json;
  // Read from them.
  StoredSite stored;
  GeoPoint touchdown;
  GeoPoint start;
  GeoPoint loiter_center;
  double loiter_radius_m = 0.0;
  bool is_right_turn = false;
  // From true north at the touchdown.
  double heading_deg = 0.0;
  double distance_m = 0.0;
};

struct KnownSiteOptions {
  Verdict verdict = Verdict::kLandable;
  std::string altitude_datum = "amsl";
  GeoPoint origin{47.4, 8.55, 450.0};
  // Of the touchdown from the origin.
  Eigen::Vector3d touchdown_in_world{120.0, -80.0, 4.0};
  double heading = 0.7;  // in world
  LoiterDirection direction = LoiterDirection::kLeft;
  int region_id = 1;
};

KnownSite MakeSite(const KnownSiteOptions& options);
// Number `index` of a fixed series: both hemispheres, up to 80 degrees, near the antimeridian.
KnownSiteOptions SomewhereOnEarth(int index);

}  // namespace freelsd
