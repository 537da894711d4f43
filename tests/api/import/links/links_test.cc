// What a link reports: read, and refused with the name of the member.
#include "api/import/links/links.h"

#include <doctest/doctest.h>

namespace freelsd {
namespace {

nlohmann::json Whole() {
  return nlohmann::json::parse(R"({
    "run": "r1", "id": "1", "system_id": 1, "is_connected": true, "age_s": 0.2, "type": "fixed wing",
    "mode": "AUTO", "is_armed": true,
    "position": {"latitude_deg": 47.0, "longitude_deg": 8.0, "altitude_m": 500.0,
                 "height_above_home_m": 70.0, "altitude_datum": "amsl"},
    "wind": {"east_mps": 1.0, "north_mps": -2.0, "source": "drift", "sd_mps": 0.6, "age_s": 3.0},
    "flight": {"id": "f-1", "name": "MAVLink system 1"},
    "mission": {"state": "current", "site": "s1", "kind": "landing", "current_item": 2},
    "engine": {"state": "running"},
    "guidance": {"phase": "glide", "site_id": "s1", "arrival_margin_m": 31.5},
    "packets": {"accepted": 5},
    "log": [{"id": 1, "at": "2026-01-01T00:00:00Z", "kind": "link", "text": "armed"},
            {"id": 4, "at": "2026-01-01T00:00:01Z", "kind": "engine", "text": "stopped"}],
    "commands": [{"id": "c-1", "state": "failed", "detail": "no mission"}]})");
}

// The pointer of the error; the code where it has none.
std::string FaultOf(const nlohmann::json& body) {
  try {
    ParseLinkReport(body.dump());
  } catch (const ApiError& error) {
    return error.errors().empty() ? error.code() : error.errors()[0].pointer;
  }
  return "none";
}

std::string FaultWith(const std::string& pointer, const nlohmann::json& value) {
  nlohmann::json body = Whole();
  body[nlohmann::json::json_pointer(pointer)] = value;
  return FaultOf(body);
}

TEST_CASE("link report: all of it is read, and what nobody knows is kept") {
  const LinkReport report = ParseLinkReport(Whole().dump());
  CHECK(report.run == "r1");
  CHECK(report.is_connected);
  CHECK(report.flight_id == "f-1");
  REQUIRE(report.decisions.size() == 2);
  CHECK(report.decisions[1].number == 4);
  CHECK(report.decisions[1].text == "stopped");
  REQUIRE(report.commands.size() == 1);
  CHECK(report.commands[0].state == CommandState::kFailed);
  CHECK(report.commands[0].detail == "no mission");
  CHECK(report.state["packets"]["accepted"] == 5);
  CHECK_FALSE(report.state.contains("commands"));
}

TEST_CASE("link report: a value of the wrong type or range is refused by its name") {
  for (const char* const pointer : {"/run",
                                    "/is_connected",
                                    "/system_id",
                                    "/mode",
                                    "/is_armed",
                                    "/position",
                                    "/position/latitude_deg",
                                    "/wind/east_mps",
                                    "/wind/source",
                                    "/mission/state",
                                    "/mission/alarm",
                                    "/engine/state",
                                    "/flight/id",
                                    "/guidance/arrival_margin_m",
                                    "/log/0/id",
                                    "/log/1/text",
                                    "/commands/0/state"}) {
    INFO(pointer);
    CHECK(FaultWith(pointer, nlohmann::json::array({1000})) == pointer);
  }
  CHECK(FaultWith("/position/latitude_deg", 91.0) == "/position/latitude_deg");
  CHECK(FaultWith("/wind/north_mps", -101.0) == "/wind/north_mps");
  CHECK(FaultWith("/engine/state", "well") == "/engine/state");
  CHECK(FaultWith("/log/1/id", 1) == "/log/1/id");
  CHECK(FaultWith("/commands", "none") == "/commands");
  CHECK(FaultWith("/commands/0", 1) == "/commands/0");
  CHECK(FaultWith("/run", "") == "/run");
  CHECK(FaultWith("/mode", std::string(1001, 'x')) == "/mode");
  CHECK(FaultWith("/log/0/text", "two\nlines") == "/log/0/text");
}

TEST_CASE("link report: lists and the body are bounded") {
  nlohmann::json log = nlohmann::json::array();
  for (int i = 0; i < 101; ++i) {
    log.push_back({{"id", i}, {"at", "t"}, {"kind", "k"}, {"text", "x"}});
  }
  CHECK(FaultWith("/log", log) == "/log");
  CHECK(FaultWith("/more", std::string(70000, 'x')) == "JsonTooLarge");
  CHECK(FaultOf(nlohmann::json::array()) == "");
  CHECK(FaultOf(Whole()) == "none");
}

TEST_CASE("link commands: a site, who confirmed it, and nothing else") {
  CHECK(ParseMissionRequest(R"({"site_id": "s-1"})").site_id == "s-1");
  const auto wind =
      ParseMissionRequest(R"({"site_id": "s", "wind": {"east_mps": 1.5, "north_mps": -2}})")
          .wind_in_world;
  CHECK(wind == Eigen::Vector2d(1.5, -2.0));
  CHECK(ParseCommandRequest("", "release").kind == "release");
  CHECK(ParseCommandRequest(R"({"confirmed_by": "me"})", "release").confirmed_by == "me");
  const auto fault = [](const char* body) -> std::string {
    try {
      ParseMissionRequest(body);
    } catch (const ApiError& error) {
      return error.errors().empty() ? error.code() : error.errors()[0].pointer;
    }
    return "none";
  };
  CHECK(fault("") == "InvalidJson");
  CHECK(fault("{}") == "/site_id");
  CHECK(fault(R"({"site_id": "../x"})") == "/site_id");
  CHECK(fault(R"({"site": "x"})") == "/site");
  CHECK(fault(R"({"site_id": "x", "wind": {"east_mps": 1}})") == "/wind/north_mps");
  CHECK(fault(R"({"site_id": "x", "wind": {"east_mps": 1, "north_mps": 101}})") ==
        "/wind/north_mps");
  CHECK(fault(R"({"site_id": "x", "confirmed_by": "a\u0007"})") == "/confirmed_by");
}

}  // namespace
}  // namespace freelsd
