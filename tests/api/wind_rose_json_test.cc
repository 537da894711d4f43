#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "tests/api/errors.h"
#include "tests/api/plans.h"

namespace freelsd {
namespace {

TEST_CASE("wind rose: entries tell where their wind comes from, and no path where there is none") {
  WindRose rose{2, {3.0}, {LandablePlan(), Plan{}}};
  rose.plans[1].reject_reason = RejectReason::kWindTooStrong;
  const nlohmann::json object = WindRoseJson(rose, Context());
  CHECK(object["directions_deg"] == nlohmann::json{0.0, 180.0});
  CHECK(object["speeds_mps"] == nlohmann::json{3.0});
  CHECK(object["altitude_datum"] == "amsl");
  const nlohmann::json& north = object["entries"][0];
  CHECK(north["wind_from_deg"] == 0.0);
  CHECK(north["verdict"] == "landable");
  CHECK(north["reject_reason"].is_null());
  CHECK(north["heading_deg"] == 0.0);
  CHECK(north["min_clearance_m"] == 2.25);
  CHECK(north["touchdown"]["altitude_m"] == doctest::Approx(405.0));
  const nlohmann::json& south = object["entries"][1];
  CHECK(south["wind_from_deg"] == 180.0);
  CHECK(south["verdict"] == "rejected");
  CHECK(south["reject_reason"] == "wind_too_strong");
  for (const char* const key : {"touchdown", "heading_deg", "min_clearance_m", "unseen_ratio"}) {
    CHECK(south[key].is_null());
  }
}

}  // namespace
}  // namespace freelsd
