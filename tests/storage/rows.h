// Rows to store.
#pragma once

#include <string>

#include "storage/storage.h"
#include "tests/storage/temporary_folder.h"

namespace freelsd {

inline const std::string kImage(64, 'a');
inline const std::string kOtherImage(64, 'b');

inline FlightRow SomeFlight(const std::string& id) {
  FlightRow flight;
  flight.id = id;
  flight.name = "a meadow";
  flight.request_json = R"({"name":"a meadow"})";
  flight.created_at_us = 1700000000000000;
  return flight;
}

inline FrameRow SomeFrame(const std::string& flight_id, const std::string& id) {
  FrameRow frame;
  frame.flight_id = flight_id;
  frame.id = id;
  frame.sha256 = kImage;
  frame.meta_json = "{}";
  return frame;
}

inline JobRow SomeJob(const std::string& id, const std::string& flight_id) {
  JobRow job;
  job.id = id;
  job.kind = "batch";
  job.flight_id = flight_id;
  return job;
}

inline SiteRow SomeSite(const std::string& id, double latitude_deg, double longitude_deg) {
  SiteRow site;
  site.id = id;
  site.flight_id = std::string("f");
  site.region_id = 3;
  site.latitude_deg = latitude_deg;
  site.longitude_deg = longitude_deg;
  site.feature_json = R"({"type":"Feature"})";
  return site;
}

// Without a map.
inline void PutSite(Storage& storage, const SiteRow& site, const Standings& others = {}) {
  storage.sites.PutEvaluation({{site}, {}, {}, {}}, others);
}

inline FlightMapRow SomeMap(const std::string& id, const std::string& flight_id, BoundingBox box) {
  FlightMapRow map;
  map.id = id;
  map.flight_id = flight_id;
  map.head_json = "{}";
  map.altitude_datum = "amsl";
  map.box = box;
  map.updated_at_us = 5;
  map.seen_at_us = 4;
  return map;
}

}  // namespace freelsd
