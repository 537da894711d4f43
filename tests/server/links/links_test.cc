// Links to autopilots in memory: silence, commands that expire, and two programs under one name.
#include "server/links/links.h"

#include <doctest/doctest.h>

namespace freelsd {
namespace {

using std::chrono::seconds;

const LinkTime kStart{std::chrono::hours(1)};

LinkReport Report(const std::string& run = "a", const nlohmann::json& more = {}) {
  nlohmann::json body{{"run", run}, {"is_connected", true}, {"age_s", 0.5}};
  if (more.is_object()) body.update(more);
  return ParseLinkReport(body.dump());
}

std::string CodeOf(const std::function<void()>& call) {
  try {
    call();
  } catch (const ApiError& error) {
    return error.code();
  }
  return "";
}

const CommandRequest kMission{"mission", "site-1", "somebody", Eigen::Vector2d(1.5, -2.0)};

TEST_CASE("links: ages go on, and a link that is silent for 5 s is not connected") {
  LinkBoard board;
  board.Put("1", Report(), kStart);
  nlohmann::json link = board.Find("1", kStart + seconds(2));
  CHECK(link["id"] == "1");
  CHECK(link["is_connected"] == true);
  CHECK(link["heard_age_s"] == 2.0);
  CHECK(link["age_s"] == 2.5);
  link = board.Find("1", kStart + seconds(5));
  CHECK(link["is_connected"] == false);
  CHECK(CodeOf([&] { board.Queue("1", kMission, kStart + seconds(5)); }) == "LinkSilent");
  CHECK(CodeOf([&] { board.Queue("2", kMission, kStart); }) == "NoSuchLink");
}

TEST_CASE("links: no command for a link that does not hear its autopilot") {
  LinkBoard board;
  board.Put("1", Report("a", {{"is_connected", false}}), kStart);
  CHECK(CodeOf([&] { board.Queue("1", kMission, kStart); }) == "LinkSilent");
}

TEST_CASE("links: a command is answered until it is reported, and its state never goes back") {
  LinkBoard board;
  board.Put("1", Report(), kStart);
  const std::string id = board.Queue("1", kMission, kStart)["id"];
  for (int i = 1; i < 3; ++i) {
    const auto taken = board.Put("1", Report(), kStart + seconds(i));
    REQUIRE(taken.commands.size() == 1);
    CHECK(taken.commands[0]["id"] == id);
    CHECK(taken.commands[0]["site_id"] == "site-1");
    CHECK(taken.commands[0]["confirmed_by"] == "somebody");
    CHECK(taken.commands[0]["wind"] == nlohmann::json{{"east_mps", 1.5}, {"north_mps", -2.0}});
  }
  const auto outcome = [&](const char* state) {
    const nlohmann::json commands{{{"id", id}, {"state", state}, {"detail", state}}};
    return board.Put("1", Report("a", {{"commands", commands}}), kStart + seconds(3)).commands;
  };
  const auto state = [&] { return board.Find("1", kStart + seconds(3))["commands"][0]["state"]; };
  CHECK(outcome("taken").empty());
  CHECK(state() == "taken");
  outcome("done");
  outcome("taken");
  CHECK(state() == "done");
  outcome("failed");
  CHECK(state() == "done");
  CHECK(board.Find("1", kStart + std::chrono::minutes(11))["commands"].empty());
}

TEST_CASE("links: a command is never handed over after 10 s") {
  LinkBoard board;
  board.Put("1", Report(), kStart);
  board.Queue("1", kMission, kStart + seconds(4));
  CHECK(board.Put("1", Report(), kStart + seconds(15)).commands.empty());
  CHECK(board.Find("1", kStart + seconds(15))["commands"][0]["state"] == "expired");
}

TEST_CASE(
    "links: a command is for the aircraft that was heard, not for the next one of that name") {
  LinkBoard board;
  board.Put("1", Report("a"), kStart);
  board.Queue("1", kMission, kStart + seconds(4));
  CHECK(CodeOf([&] { board.Put("1", Report("b"), kStart + seconds(4)); }) == "LinkInUse");
  CHECK(board.Put("1", Report("b"), kStart + seconds(5)).commands.empty());
  CHECK(board.Find("1", kStart + seconds(5))["commands"][0]["state"] == "expired");
  // What the other program reports on it is not believed.
  const std::string id = board.Find("1", kStart + seconds(5))["commands"][0]["id"];
  const nlohmann::json commands{{{"id", id}, {"state", "done"}}};
  board.Put("1", Report("b", {{"commands", commands}}), kStart + seconds(6));
  CHECK(board.Find("1", kStart + seconds(6))["commands"][0]["state"] == "expired");
}

TEST_CASE("links: decisions are new once in each run") {
  LinkBoard board;
  const auto put = [&](const char* run, const std::vector<int>& ids, int second) {
    nlohmann::json log = nlohmann::json::array();
    for (const int id : ids) {
      log.push_back({{"id", id}, {"at", "t"}, {"kind", "link"}, {"text", "x"}});
    }
    return board.Put("1", Report(run, {{"log", log}}), kStart + seconds(second)).new_decisions;
  };
  CHECK(put("a", {1, 2}, 0).size() == 2);
  const auto more = put("a", {1, 2, 3}, 1);
  REQUIRE(more.size() == 1);
  CHECK(more[0].number == 3);
  CHECK(put("a", {}, 2).empty());
  CHECK(put("a", {3}, 3).empty());
  CHECK(put("b", {1}, 9).size() == 1);
}

TEST_CASE("links: memory is bounded, and a silent link makes room") {
  LinkBoard board;
  const size_t limit = kLimits.links.max_num_links;
  for (size_t i = 0; i < limit; ++i) board.Put("l" + std::to_string(i), Report(), kStart);
  CHECK(CodeOf([&] { board.Put("more", Report(), kStart + seconds(1)); }) == "TooManyLinks");
  for (size_t i = 1; i < limit; ++i) {
    board.Put("l" + std::to_string(i), Report(), kStart + seconds(5));
  }
  board.Put("more", Report(), kStart + seconds(6));
  CHECK(board.List(kStart + seconds(6)).size() == limit);
  CHECK(CodeOf([&] { board.Find("l0", kStart); }) == "NoSuchLink");
}

TEST_CASE("links: commands that wait are bounded, and so are those that are remembered") {
  LinkBoard board;
  LinkTime now = kStart;
  board.Put("1", Report(), now);
  for (size_t i = 0; i < kLimits.links.max_num_queued_commands; ++i) {
    board.Queue("1", kMission, now);
  }
  CHECK(CodeOf([&] { board.Queue("1", kMission, now); }) == "TooManyRequests");
  now += seconds(11);
  for (int i = 0; i < 100; ++i) {
    now += seconds(4);
    board.Put("1", Report(), now);
    board.Queue("1", kMission, now);
  }
  CHECK(board.Find("1", now)["commands"].size() == kLimits.links.max_num_commands);
}

}  // namespace
}  // namespace freelsd
