// Of several flights over one ground, which site speaks.
#include "server/recall/superseding.h"

#include <doctest/doctest.h>

#include "tests/server/meadow.h"

namespace freelsd {
namespace {

constexpr BoundingBox kEverywhere{-180.0, -90.0, 180.0, 90.0};

SiteRow SeenAt(const std::string& flight_id, int64_t seen_at_us, bool is_rejected = false) {
  SiteRow site = MeadowSite("amsl");
  site.id = flight_id + "-r1";
  site.flight_id = flight_id;
  site.seen_at_us = seen_at_us;
  site.is_evidence = true;
  if (is_rejected) site.recall.reset();
  return site;
}

// As an evaluation stores it.
void Store(Storage& storage, SiteRow site) {
  const Standing standing = StandingOf(storage, site);
  site.superseded_by = standing.superseded_by;
  storage.sites.Put(site, "map", standing.supersedes);
}

std::string RecalledIds(const Storage& storage) {
  std::string ids;
  for (const auto& row : storage.sites.ListRecallable(kEverywhere)) ids += row->site_id + " ";
  return ids;
}

TEST_CASE("superseding: the ground photographed last speaks, in whatever order the flights came") {
  for (const bool is_newer_first : {false, true}) {
    INFO(is_newer_first);
    const TemporaryFolder folder;
    Storage storage(folder.path());
    const SiteRow older = SeenAt("a", 1000), newer = SeenAt("b", 2000);
    Store(storage, is_newer_first ? newer : older);
    Store(storage, is_newer_first ? older : newer);
    CHECK(RecalledIds(storage) == "b-r1 ");
    CHECK(storage.sites.Find("a-r1")->superseded_by == "b-r1");
    CHECK_FALSE(storage.sites.Find("b-r1")->superseded_by);
  }
}

TEST_CASE("superseding: an old flight that is sent late does not win over a later rejection") {
  const TemporaryFolder folder;
  Storage storage(folder.path());
  Store(storage, SeenAt("b", 2000, true));
  Store(storage, SeenAt("a", 1000));
  CHECK(RecalledIds(storage).empty());
  CHECK(storage.sites.CountOverruled(kEverywhere) == 1);
  // Evaluated again, nothing changes.
  Store(storage, SeenAt("a", 1000));
  CHECK(RecalledIds(storage).empty());
}

TEST_CASE("superseding: who forgets one rejection does not bring back what another one rejects") {
  const TemporaryFolder folder;
  Storage storage(folder.path());
  Store(storage, SeenAt("a", 1000));
  Store(storage, SeenAt("b", 2000, true));
  Store(storage, SeenAt("c", 3000, true));
  CHECK(RecalledIds(storage).empty());
  CHECK(ForgetSite(storage, "c-r1"));
  CHECK(RecalledIds(storage).empty());
  CHECK(storage.sites.Find("a-r1")->superseded_by == "b-r1");
  CHECK(ForgetSite(storage, "b-r1"));
  CHECK(RecalledIds(storage) == "a-r1 ");
  CHECK_FALSE(ForgetSite(storage, "b-r1"));
}

TEST_CASE("superseding: what says nothing of the ground supersedes nothing") {
  const TemporaryFolder folder;
  Storage storage(folder.path());
  Store(storage, SeenAt("a", 1000));
  SiteRow silent = SeenAt("b", 2000, true);
  silent.is_evidence = false;
  Store(storage, silent);
  CHECK(RecalledIds(storage) == "a-r1 ");
}

TEST_CASE("superseding: other ground is left alone") {
  const TemporaryFolder folder;
  Storage storage(folder.path());
  Store(storage, SeenAt("a", 1000));
  SiteRow elsewhere = SeenAt("b", 2000);
  Replan replan = ParseReplan(elsewhere.replan_json);
  replan.origin.longitude_deg += 0.01;
  elsewhere.replan_json = ReplanJson(replan);
  elsewhere.longitude_deg += 0.01;
  Store(storage, elsewhere);
  CHECK(RecalledIds(storage) == "a-r1 b-r1 ");
}

}  // namespace
}  // namespace freelsd
