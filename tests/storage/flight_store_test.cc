#include "storage/flight_store.h"

#include <string>
#include <thread>
#include <vector>

#include <doctest/doctest.h>

#include "storage/storage.h"
#include "tests/storage/place.h"
#include "tests/storage/rows.h"

namespace freelsd {
namespace {

TEST_CASE(
    "flight store: deleting a flight keeps its sites and the images that another flight needs") {
  const StoragePlace place;
  Storage storage(place.options());
  FrameRow own = SomeFrame("f", "own");
  own.sha256 = kOtherImage;
  storage.flights.Insert(SomeFlight("f"));
  storage.flights.Insert(SomeFlight("g"));
  storage.images.Write(kImage, "shared");
  storage.images.Write(kOtherImage, "own");
  storage.frames.Insert("f", {SomeFrame("f", "one"), own}, SomeJob("j", "f"));
  storage.frames.Insert("g", {SomeFrame("g", "one")});
  PutSite(storage, SomeSite("f-r3", 50.0, 8.0));
  CHECK(storage.flights.Delete("f"));
  CHECK_FALSE(storage.flights.Delete("f"));
  CHECK(storage.frames.List("f").empty());
  CHECK_FALSE(storage.jobs.Find("j"));
  CHECK(storage.images.Read(kImage) == "shared");
  CHECK_FALSE(storage.images.Read(kOtherImage));
  CHECK(storage.sites.Find("f-r3"));
}

TEST_CASE("flight store: pages list every flight once, newest first, with its numbers") {
  const StoragePlace place;
  Storage storage(place.options());
  for (const char* const id : {"a", "b", "c"}) storage.flights.Insert(SomeFlight(id));
  storage.images.Write(kImage, "image");
  storage.frames.Insert("b", {SomeFrame("b", "one"), SomeFrame("b", "two")}, SomeJob("j", "b"));
  storage.frames.SetState("b", "one", FrameState::kProcessed, "");
  storage.flights.ReplaceRegions("b", {{7, "{}", "[]"}});
  PutSite(storage, SomeSite("f-r3", 50.0, 8.0));
  const FlightPage first = storage.flights.ListPage(2, std::nullopt);
  REQUIRE(first.flights.size() == 2);
  CHECK(first.has_more);
  CHECK(first.flights[0].flight.id == "c");
  const FlightSummary& busy = first.flights[1];
  CHECK(busy.flight.id == "b");
  CHECK(busy.num_frames == 2);
  CHECK(busy.num_queued_frames == 1);
  CHECK(busy.num_regions == 1);
  CHECK(busy.num_sites == 0);
  CHECK(busy.has_unfinished_job);
  const FlightPage second = storage.flights.ListPage(2, busy.number);
  REQUIRE(second.flights.size() == 1);
  CHECK_FALSE(second.has_more);
  CHECK(second.flights[0].flight.id == "a");
  CHECK(storage.flights.Count() == 3);
  CHECK_FALSE(storage.flights.FindSummary("d"));
}

TEST_CASE(
    "flight store: a flight goes with its sites, and with the images of both, in one commit") {
  const StoragePlace place;
  Storage storage(place.options());
  storage.flights.Insert(SomeFlight("f"));
  PutSite(storage, SomeSite("f-r3", 50.0, 8.0));
  storage.images.Write(kImage, "of a frame");
  storage.frames.Insert("f", {SomeFrame("f", "one")}, SomeJob("j", "f"));
  EvaluationRows rows;
  rows.forgotten_sites = {"f-r3"};
  rows.deleted_flight = "f";
  storage.sites.PutEvaluation(rows, {});
  CHECK_FALSE(storage.flights.Find("f"));
  CHECK_FALSE(storage.images.Read(kImage));
  CHECK_FALSE(storage.sites.Find("f-r3"));
}

TEST_CASE(
    "flight store: retired images are gone, unless another flight needs them, and rows stay") {
  const StoragePlace place;
  Storage storage(place.options());
  storage.flights.Insert(SomeFlight("f"));
  storage.flights.Insert(SomeFlight("g"));
  storage.images.Write(kImage, "shared");
  storage.images.Write(kOtherImage, "own");
  FrameRow own = SomeFrame("f", "two");
  own.sha256 = kOtherImage;
  storage.frames.Insert("f", {SomeFrame("f", "one"), own});
  storage.frames.Insert("g", {SomeFrame("g", "one")});
  CHECK(storage.images.NumBytes() == 9);
  CHECK_FALSE(storage.flights.RetireImages("f"));
  CHECK(storage.images.Read(kOtherImage));
  CHECK_FALSE(storage.flights.Find("f")->has_retired_images);
  for (const char* const id : {"one", "two"}) {
    storage.frames.SetState("f", id, FrameState::kProcessed, "");
  }
  CHECK(storage.flights.RetireImages("f"));
  CHECK(storage.images.Read(kImage));
  CHECK_FALSE(storage.images.Read(kOtherImage));
  CHECK(storage.images.NumBytes() == 6);
  CHECK(storage.flights.Find("f")->has_retired_images);
  CHECK(storage.frames.List("f").size() == 2);
}

TEST_CASE("flight store: changes of one flight from several threads are all kept") {
  constexpr int kNumThreads = 4;
  constexpr int kNumChanges = 20;
  const StoragePlace place;
  Storage storage(place.options());
  storage.flights.Insert(SomeFlight("f"));
  std::vector<std::thread> threads;
  threads.reserve(kNumThreads);
  for (int i = 0; i < kNumThreads; ++i) {
    threads.emplace_back([&storage] {
      for (int k = 0; k < kNumChanges; ++k) {
        storage.flights.Change("f", [](FlightRow& flight) { ++flight.num_rejected_frames; });
        storage.flights.Find("f");
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  CHECK(storage.flights.Find("f")->num_rejected_frames == kNumThreads * kNumChanges);
  CHECK_FALSE(storage.flights.Change("g", [](FlightRow&) {}));
}

TEST_CASE("flight store: regions are replaced as one snapshot and keep their order") {
  const StoragePlace place;
  Storage storage(place.options());
  storage.flights.Insert(SomeFlight("f"));
  storage.flights.ReplaceRegions("f", {{7, "seven", "h7"}, {2, "two", "h2"}});
  storage.flights.ReplaceRegions("f", {{9, "nine", "h9"}, {7, "seven", "h7"}});
  const std::vector<RegionRow> regions = storage.flights.ListRegions("f");
  REQUIRE(regions.size() == 2);
  CHECK(regions[0].id == 9);
  CHECK(regions[1].feature_json == "seven");
  CHECK(regions[1].history_json == "h7");
}

TEST_CASE("flight store: text that looks like SQL is data") {
  const StoragePlace place;
  Storage storage(place.options());
  FlightRow flight = SomeFlight("f");
  flight.name = "'); DROP TABLE flights; --";
  storage.flights.Insert(flight);
  CHECK(storage.flights.Find("f")->name == flight.name);
  CHECK_FALSE(storage.flights.Find("' OR '1' = '1"));
}

}  // namespace
}  // namespace freelsd
