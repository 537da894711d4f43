// Several processes on one PostgreSQL database: each Storage here stands for one.
#include <atomic>
#include <chrono>
#include <filesystem>
#include <future>
#include <memory>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include <doctest/doctest.h>

#include "storage/storage.h"
#include "tests/storage/place.h"
#include "tests/storage/rows.h"

TEST_SUITE_BEGIN("postgresql" * doctest::skip());

namespace freelsd {
namespace {

constexpr BoundingBox kAround{7.0, 49.0, 9.0, 51.0};

std::string ImageName(int number) {
  std::string name = std::to_string(number);
  return std::string(64 - name.size(), 'c') + name;
}

// Runs `act` with both storages at the same time.
void InBoth(Storage& one, Storage& other, const std::function<void(Storage&, int)>& act) {
  std::thread first([&] { act(one, 0); });
  std::thread second([&] { act(other, 1); });
  first.join();
  second.join();
}

TEST_CASE("postgres: frames from two processes have sequence numbers without a gap") {
  constexpr int kNumFrames = 20;
  const StoragePlace place;
  Storage one(place.OptionsOfOne());
  Storage other(place.OptionsOfOther());
  one.flights.Insert(SomeFlight("f"));
  one.images.Write(kImage, "pixels");
  InBoth(one, other, [](Storage& storage, int who) {
    for (int i = 0; i < kNumFrames; ++i) {
      storage.frames.Insert("f", {SomeFrame("f", std::to_string(who) + "-" + std::to_string(i))});
    }
  });
  const std::vector<FrameRow> frames = one.frames.List("f");
  REQUIRE(frames.size() == 2 * kNumFrames);
  for (size_t i = 0; i < frames.size(); ++i) {
    CHECK(frames[i].sequence == static_cast<int64_t>(i) + 1);
    if (i > 0) CHECK(frames[i].arrived_at_us > frames[i - 1].arrived_at_us);
  }
}

TEST_CASE("postgres: a server that does not see the stored images does not start") {
  const StoragePlace place;
  {
    Storage storage(place.OptionsOfOne());
    storage.flights.Insert(SomeFlight("f"));
    storage.images.Write(kImage, "pixels");
    storage.frames.Insert("f", {SomeFrame("f", "a")});
  }
  const std::filesystem::path elsewhere = place.images_folder().string() + "-elsewhere";
  std::filesystem::rename(place.images_folder(), elsewhere);
  CHECK_THROWS_AS(Storage(place.OptionsOfOne()), StorageError);
  std::filesystem::remove_all(place.images_folder());
  std::filesystem::rename(elsewhere, place.images_folder());
  CHECK(Storage(place.OptionsOfOne()).images.Read(kImage) == "pixels");
}

TEST_CASE("postgres: images are not retired while another server may be receiving the flight") {
  const StoragePlace place;
  Storage one(place.OptionsOfOne());
  Storage other(place.OptionsOfOther());
  one.images.Write(kImage, "pixels");
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const int64_t now_us = std::chrono::duration_cast<std::chrono::microseconds>(now).count();
  for (const int minutes : {1, 11}) {
    const std::string id = std::to_string(minutes);
    one.flights.Insert(SomeFlight(id));
    FrameRow frame = SomeFrame(id, "a");
    frame.arrived_at_us = now_us - minutes * int64_t{60000000};
    one.frames.Insert(id, {frame});
    one.frames.SetState(id, "a", FrameState::kProcessed, "");
    CHECK(other.flights.RetireImages(id) == (minutes == 11));
    CHECK(one.flights.Find(id)->has_retired_images == (minutes == 11));
  }
}

TEST_CASE("postgres: who waits for one flight does not keep telemetry of others") {
  const StoragePlace place;
  Storage one(place.OptionsOfOne());
  Storage other(place.OptionsOfOther());
  for (const char* const id : {"held", "free"}) one.flights.Insert(SomeFlight(id));
  const std::vector<TelemetryRow> rows{{TelemetryKind::kWind, 1, {1.0, 2.0, 0.0, 0.0}}};
  std::promise<void> is_held, may_end;
  std::thread holder([&] {
    other.flights.Change("held", [&](FlightRow&) {
      is_held.set_value();
      may_end.get_future().wait();
    });
  });
  is_held.get_future().wait();
  auto held = std::async(std::launch::async, [&] { return one.telemetry.Put("held", rows); });
  CHECK(held.wait_for(std::chrono::milliseconds(200)) == std::future_status::timeout);
  CHECK(one.telemetry.Put("free", rows));
  CHECK(held.wait_for(std::chrono::seconds(0)) == std::future_status::timeout);
  may_end.set_value();
  holder.join();
  CHECK(held.get());
  CHECK(one.telemetry.Recent("held", TelemetryKind::kWind, 9).size() == 1);
}

TEST_CASE("postgres: versions that are held are told until the hold ends") {
  const StoragePlace place;
  Storage one(place.OptionsOfOne());
  Storage other(place.OptionsOfOther());
  uint64_t before = one.sites.Version();
  {
    const auto hold = one.HoldVersions();
    other.obstacles.Put({}, 0);
    CHECK(one.sites.Version() == before);
    CHECK(std::async(std::launch::async, [&] { return one.sites.Version(); }).get() == before + 1);
    const auto within = one.HoldVersions();
    CHECK(one.sites.Version() == before);
  }
  CHECK(one.sites.Version() == before + 1);
}

TEST_CASE("postgres: the same frame sent to two processes is stored once") {
  constexpr int kNumFrames = 20;
  const StoragePlace place;
  Storage one(place.OptionsOfOne());
  Storage other(place.OptionsOfOther());
  one.flights.Insert(SomeFlight("f"));
  one.images.Write(kImage, "pixels");
  std::atomic<int> num_stored{0}, num_refused{0};
  InBoth(one, other, [&](Storage& storage, int) {
    for (int i = 0; i < kNumFrames; ++i) {
      try {
        storage.frames.Insert("f", {SomeFrame("f", std::to_string(i))});
        ++num_stored;
      } catch (const StorageError&) {
        ++num_refused;
      }
    }
  });
  CHECK(num_stored == kNumFrames);
  CHECK(num_refused == kNumFrames);
  CHECK(one.frames.List("f").size() == kNumFrames);
}

TEST_CASE("postgres: changes of one flight from two processes are all kept") {
  constexpr int kNumChanges = 20;
  const StoragePlace place;
  Storage one(place.OptionsOfOne());
  Storage other(place.OptionsOfOther());
  one.flights.Insert(SomeFlight("f"));
  InBoth(one, other, [](Storage& storage, int) {
    for (int i = 0; i < kNumChanges; ++i) {
      storage.flights.Change("f", [](FlightRow& flight) { ++flight.num_rejected_frames; });
    }
  });
  CHECK(one.flights.Find("f")->num_rejected_frames == 2 * kNumChanges);
}

TEST_CASE("postgres: what another process changes of sites and obstacles is seen at once") {
  const StoragePlace place;
  Storage one(place.OptionsOfOne());
  Storage other(place.OptionsOfOther());
  CHECK(one.sites.ListRecallable(kAround).empty());
  SiteRow site = SomeSite("f-r1", 50.0, 8.0);
  site.recall = RecallData{true, 300.0, "amsl", 0.7, "{}"};
  const uint64_t before = one.sites.Version();
  PutSite(other, site);
  CHECK(one.sites.Version() > before);
  CHECK(one.sites.ListRecallable(kAround).size() == 1);
  CHECK(one.sites.BoundsOfRecallable().min_altitude_m == 300.0);
  CHECK(other.sites.Delete("f-r1"));
  CHECK(one.sites.ListRecallable(kAround).empty());
  const uint64_t no_wire = one.obstacles.Version();
  other.obstacles.Put({{"wire", "{}", {7.0, 49.0, 8.0, 50.0}, std::nullopt, 1}}, 0);
  CHECK(one.obstacles.Version() > no_wire);
  CHECK(one.obstacles.List().size() == 1);
}

TEST_CASE("postgres: ids of maps differ between processes") {
  constexpr int kNumMaps = 20;
  const StoragePlace place;
  Storage one(place.OptionsOfOne());
  Storage other(place.OptionsOfOther());
  std::array<std::vector<std::string>, 2> ids;
  InBoth(one, other, [&](Storage& storage, int who) {
    for (int i = 0; i < kNumMaps; ++i) {
      ids[static_cast<size_t>(who)].push_back(storage.maps.NewId("f"));
    }
  });
  std::set<std::string> all(ids[0].begin(), ids[0].end());
  all.insert(ids[1].begin(), ids[1].end());
  CHECK(all.size() == 2 * kNumMaps);
}

// One process deletes flights, which removes their image, while the other stores frames with the
// same image.
TEST_CASE("postgres: a stored frame has its image, while another process removes the same image") {
  constexpr int kNumRounds = 40;
  const StoragePlace place;
  Storage one(place.OptionsOfOne());
  Storage other(place.OptionsOfOther());
  int num_stored = 0;
  InBoth(one, other, [&](Storage& storage, int who) {
    for (int i = 0; i < kNumRounds; ++i) {
      const std::string flight = (who == 0 ? "gone-" : "kept-") + std::to_string(i);
      storage.flights.Insert(SomeFlight(flight));
      FrameRow frame = SomeFrame(flight, "one");
      frame.sha256 = ImageName(i / 4);
      storage.images.Write(frame.sha256, "pixels");
      try {
        storage.frames.Insert(flight, {frame});
        if (who == 1) ++num_stored;
      } catch (const StorageError&) {
        // The image was removed between the two calls; a client sends it again.
      }
      if (who == 0) storage.flights.Delete(flight);
    }
  });
  CHECK(num_stored > 0);
  int num_with_image = 0;
  for (const FlightRow& flight : one.flights.List()) {
    for (const FrameRow& frame : one.frames.List(flight.id)) {
      num_with_image += one.images.Read(frame.sha256) == "pixels" ? 1 : 0;
    }
  }
  CHECK(num_with_image == num_stored);
}

TEST_CASE(
    "postgres: a start leaves young images and unfinished maps, which others may be writing") {
  const StoragePlace place;
  Storage one(place.OptionsOfOne());
  one.images.Write(kImage, "just written");
  FlightMapRow map;
  map.id = std::string("f/1");
  map.flight_id = std::string("f");
  one.maps.Stage(map, {{{0, 0, 0}, "tile"}}, {});
  StorageOptions options = place.OptionsOfOther();
  options.unused_image_age_s = 3600.0;
  const Storage other(options);
  CHECK(one.images.Read(kImage) == "just written");
  CHECK(one.maps.ReadTile("f/1", {0, 0, 0}) == "tile");
}

TEST_CASE("postgres: removing an image waits for a frame that another process is storing") {
  const StoragePlace place;
  Storage storage(place.options());
  storage.flights.Insert(SomeFlight("f"));
  storage.images.Write(kImage, "pixels");
  storage.frames.Insert("f", {SomeFrame("f", "one")});
  place.Execute("UPDATE frames SET stored_image = NULL");
  std::thread other([&place] {
    place.Execute("BEGIN; UPDATE frames SET stored_image = sha256; SELECT pg_sleep(3); COMMIT");
  });
  std::this_thread::sleep_for(std::chrono::seconds(1));
  storage.images.RemoveUnused(kImage);
  other.join();
  CHECK(storage.images.Read(kImage) == "pixels");
}

TEST_CASE("postgres: a turn to change sites is one among all processes") {
  const StoragePlace place;
  Storage one(place.OptionsOfOne());
  Storage other(place.OptionsOfOther());
  std::unique_ptr<SiteTurn> turn = one.sites.TakeTurn();
  std::future<uint64_t> seen = std::async(std::launch::async, [&other] {
    const std::unique_ptr<SiteTurn> next = other.sites.TakeTurn();
    return other.sites.Find("own") ? other.sites.Version() : 0;
  });
  CHECK(seen.wait_for(std::chrono::milliseconds(200)) == std::future_status::timeout);
  turn->PutEvaluation({{SomeSite("own", 50.0, 8.0)}, {}, {}, {}}, {});
  CHECK(seen.get() == one.sites.Version());
}

TEST_CASE("postgres: a turn whose connection was lost writes nothing, and the next one begins") {
  const StoragePlace place;
  Storage one(place.OptionsOfOne());
  Storage other(place.OptionsOfOther());
  std::unique_ptr<SiteTurn> turn = one.sites.TakeTurn();
  place.Execute(
      "SELECT pg_terminate_backend(pid) FROM pg_stat_activity "
      "WHERE state = 'idle in transaction'");
  PutSite(other, SomeSite("next", 50.0, 8.0));
  CHECK_THROWS_AS(turn->PutEvaluation({{SomeSite("late", 50.0, 8.0)}, {}, {}, {}}, {}),
                  StorageError);
  CHECK_FALSE(one.sites.Find("late"));
  CHECK(one.sites.Find("next"));
}

TEST_CASE("postgres: a start removes files that were left without a row") {
  const StoragePlace place;
  { const Storage storage(place.options()); }
  const std::filesystem::path shelf = place.images_folder() / "aa";
  std::filesystem::create_directories(shelf);
  for (const std::string& name : {kImage, kImage + ".1.2-part"}) {
    CHECK(std::system(("echo left > " + (shelf / name).string()).c_str()) == 0);
  }
  const Storage storage(place.options());
  CHECK(std::filesystem::is_empty(shelf));
}

}  // namespace
}  // namespace freelsd

TEST_SUITE_END();
