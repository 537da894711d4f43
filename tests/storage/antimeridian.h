// A map and a site on both sides of the antimeridian, and where they must be found.
#pragma once

#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "tests/storage/rows.h"

namespace freelsd {

inline constexpr BoundingBox kAcross{179.9, -17.1, -179.95, -16.9};

inline void PutAcross(Storage& storage) {
  storage.maps.Stage(SomeMap("f/1", "f", kAcross), {}, {});
  SiteRow site = SomeSite("g-r1", -17.0, 179.95);
  site.map_id = "f/1";
  site.map_box = kAcross;
  site.recall = RecallData{};
  storage.sites.PutEvaluation({{site}, {}, {"f/1"}, {}}, {});
}

inline void CheckFoundAcross(const Storage& storage) {
  // The last three boxes cross the antimeridian; the last of them leaves [-180, 180].
  for (const BoundingBox& box : {BoundingBox{179.92, -17.0, 179.93, -17.0},
                                 BoundingBox{-179.97, -17.0, -179.96, -17.0},
                                 BoundingBox{180.0, -17.0, 180.0, -17.0},
                                 BoundingBox{-180.0, -17.0, -180.0, -17.0},
                                 BoundingBox{-180.0, -90.0, 180.0, 90.0},
                                 BoundingBox{179.99, -17.0, -179.99, -17.0},
                                 BoundingBox{179.0, -17.0, -179.0, -17.0},
                                 BoundingBox{179.98, -17.0, 180.015, -17.0}}) {
    CAPTURE(box.west_deg);
    CAPTURE(box.east_deg);
    CHECK(storage.sites.ListMaps(box).size() == 1);
    CHECK(storage.sites.ListRecallable(box).size() == 1);
    CHECK(storage.sites.ListAccepted(box) == std::vector<std::string>{"g-r1"});
  }
  for (const BoundingBox& box : {BoundingBox{0.0, -17.0, 1.0, -17.0},
                                 BoundingBox{-179.9, -17.0, 179.8, -17.0},
                                 BoundingBox{179.92, -16.0, 179.93, -15.0}}) {
    CAPTURE(box.west_deg);
    CHECK(storage.sites.ListMaps(box).empty());
    CHECK(storage.sites.ListRecallable(box).empty());
    CHECK(storage.sites.ListAccepted(box).empty());
  }
}

}  // namespace freelsd
