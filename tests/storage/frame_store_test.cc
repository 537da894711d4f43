#include "storage/frame_store.h"

#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "storage/storage.h"
#include "tests/storage/place.h"
#include "tests/storage/rows.h"

namespace freelsd {
namespace {

TEST_CASE("frame store: what the engine took of frames comes in their order, of those it took") {
  const StoragePlace place;
  Storage storage(place.options());
  storage.flights.Insert(SomeFlight("f"));
  storage.images.Write(kImage, "pixels");
  storage.frames.Insert("f", {SomeFrame("f", "z"), SomeFrame("f", "m"), SomeFrame("f", "a")});
  storage.frames.Resolve("f", "a", "{\"n\":3}");
  storage.frames.Resolve("f", "z", "{\"n\":1}");
  std::vector<std::string> taken;
  storage.frames.ForEachResolved("f", [&taken](const std::string& json) { taken.push_back(json); });
  CHECK(taken == std::vector<std::string>{"{\"n\":1}", "{\"n\":3}"});
}

TEST_CASE(
    "frame store: of a long flight, each resolved frame comes once, and the store may be used") {
  constexpr int kNumFrames = 2001;
  const StoragePlace place;
  Storage storage(place.options());
  storage.flights.Insert(SomeFlight("f"));
  storage.images.Write(kImage, "pixels");
  std::vector<FrameRow> frames;
  for (int i = 0; i < kNumFrames; ++i) {
    frames.push_back(SomeFrame("f", std::to_string(i)));
    if (i % 2 == 0) frames.back().resolved_json = std::to_string(i);
  }
  storage.frames.Insert("f", frames);
  int next = 0;
  storage.frames.ForEachResolved("f", [&](const std::string& json) {
    CHECK(json == std::to_string(next));
    next += 2;
    if (next == 2) storage.frames.SetState("f", "0", FrameState::kProcessed, "");
  });
  CHECK(next == kNumFrames + 1);
}

TEST_CASE("frame store: frames of a refused insert are not there, nor is their job") {
  const StoragePlace place;
  Storage storage(place.options());
  storage.flights.Insert(SomeFlight("f"));
  storage.images.Write(kImage, "pixels");
  storage.frames.Insert("f", {SomeFrame("f", "one")});
  CHECK_THROWS_AS(
      storage.frames.Insert("f", {SomeFrame("f", "two"), SomeFrame("f", "one")}, SomeJob("j", "f")),
      StorageError);
  CHECK(storage.frames.List("f").size() == 1);
  CHECK_FALSE(storage.jobs.Find("j"));
}

TEST_CASE("frame store: a frame without its image file is refused") {
  const StoragePlace place;
  Storage storage(place.options());
  storage.flights.Insert(SomeFlight("f"));
  CHECK_THROWS_AS(storage.frames.Insert("f", {SomeFrame("f", "one")}), StorageError);
  CHECK(storage.frames.List("f").empty());
}

TEST_CASE("frame store: frames are counted by state and taken in order") {
  const StoragePlace place;
  Storage storage(place.options());
  storage.flights.Insert(SomeFlight("f"));
  storage.images.Write(kImage, "pixels");
  storage.frames.Insert("f", {SomeFrame("f", "b"), SomeFrame("f", "a"), SomeFrame("f", "c")});
  CHECK(storage.frames.CountQueued() == 3);
  CHECK(storage.frames.OldestQueuedArrival() == storage.frames.List("f")[0].arrived_at_us);
  CHECK(storage.frames.Next("f", 0)->id == "b");
  CHECK(storage.frames.Next("f", 1)->id == "a");
  storage.frames.SetState("f", "b", FrameState::kProcessed, "");
  storage.frames.SetState("f", "a", FrameState::kRejected, "too dark");
  CHECK(storage.frames.CountQueued() == 1);
  CHECK(storage.frames.Find("f", "a")->reason == "too dark");
  CHECK(storage.flights.ListWithQueuedFrames() == std::vector<std::string>{"f"});
  CHECK(storage.frames.NextQueuedSequence("f", 0) == 3);
  CHECK_FALSE(storage.frames.NextQueuedSequence("f", 3));
  CHECK_FALSE(storage.frames.Next("f", 3));
}

}  // namespace
}  // namespace freelsd
