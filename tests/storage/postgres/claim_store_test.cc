// Workers that share the flights of a PostgreSQL database: each Storage here stands for one.
#include "storage/claim_store.h"

#include <chrono>
#include <memory>
#include <optional>
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

StorageOptions AsWorker(StorageOptions options) {
  options.is_worker = true;
  options.lease_s = 600.0;
  return options;
}

// The leases of all workers that have a flight are over.
void EndLeases(const StoragePlace& place) {
  place.Execute(
      "UPDATE workers SET expires_at = clock_timestamp() - interval '1 ms' "
      "WHERE token IN (SELECT token FROM claims)");
}

std::optional<Claim> ClaimWithin(Storage& storage, std::chrono::seconds patience) {
  const auto deadline = std::chrono::steady_clock::now() + patience;
  while (std::chrono::steady_clock::now() < deadline) {
    if (std::optional<Claim> claim = storage.claims.ClaimNext()) return claim;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return std::nullopt;
}

void InsertFlightWithFrame(Storage& storage, const std::string& id) {
  storage.flights.Insert(SomeFlight(id));
  storage.frames.Insert(id, {SomeFrame(id, "1")});
}

TEST_CASE("claims: each flight with work is claimed by one of two workers, the oldest first") {
  constexpr int kNumFlights = 20;
  const StoragePlace place;
  Storage one(AsWorker(place.OptionsOfOne()));
  Storage other(AsWorker(place.OptionsOfOther()));
  one.images.Write(kImage, "pixels");
  for (int i = 0; i < kNumFlights; ++i) InsertFlightWithFrame(one, "f" + std::to_string(i));
  CHECK(one.claims.ClaimNext()->flight_id == "f0");
  std::vector<std::thread> threads;
  for (Storage* storage : {&one, &other}) {
    threads.emplace_back([storage] {
      // A flight may be passed over while the other one has its row.
      for (int i = 0; i < 2 * kNumFlights; ++i) storage->claims.ClaimNext();
    });
  }
  for (std::thread& thread : threads) thread.join();
  std::vector<std::string> claimed = one.claims.ListClaimed();
  const std::vector<std::string> of_other = other.claims.ListClaimed();
  claimed.insert(claimed.end(), of_other.begin(), of_other.end());
  CHECK(claimed.size() == kNumFlights);
  CHECK(std::set<std::string>(claimed.begin(), claimed.end()).size() == kNumFlights);
}

TEST_CASE("claims: only flights with work are claimed, and again after their release") {
  const StoragePlace place;
  Storage one(AsWorker(place.OptionsOfOne()));
  Storage other(AsWorker(place.OptionsOfOther()));
  one.images.Write(kImage, "pixels");
  one.flights.Insert(SomeFlight("idle"));
  CHECK_FALSE(one.claims.ClaimNext());
  InsertFlightWithFrame(one, "f");
  JobRow job;
  job.id = "j";
  job.kind = "finish";
  job.flight_id = "idle";
  one.jobs.Insert(job);
  CHECK(one.claims.ClaimNext()->flight_id == "idle");
  CHECK(one.claims.ClaimNext()->flight_id == "f");
  CHECK_FALSE(other.claims.ClaimNext());
  one.claims.Release("f");
  // Only its own are a worker's to give up.
  other.claims.Release("idle");
  const std::optional<Claim> taken = other.claims.ClaimNext();
  REQUIRE(taken);
  CHECK(taken->flight_id == "f");
  CHECK(taken->num_lost == 0);
  CHECK(one.claims.ListClaimed() == std::vector<std::string>{"idle"});
  CHECK(other.flights.Delete("f"));
  CHECK(other.claims.ListClaimed().empty());
}

TEST_CASE("claims: what a silent worker had goes to another, and the silent one writes nothing") {
  const StoragePlace place;
  Storage silent(AsWorker(place.OptionsOfOne()));
  Storage other(AsWorker(place.OptionsOfOther()));
  silent.images.Write(kImage, "pixels");
  InsertFlightWithFrame(silent, "f");
  CHECK(silent.claims.ClaimNext());
  CHECK_FALSE(other.claims.ClaimNext());
  EndLeases(place);
  // Late, but before anybody took note.
  silent.frames.SetState("f", "1", FrameState::kQueued, "");
  const std::optional<Claim> taken = other.claims.ClaimNext();
  REQUIRE(taken);
  CHECK(taken->flight_id == "f");
  CHECK(taken->num_lost == 1);
  CHECK_THROWS_WITH_AS(silent.frames.SetState("f", "1", FrameState::kProcessed, ""),
                       doctest::Contains("lease was over"),
                       StorageError);
  CHECK_THROWS_AS(PutSite(silent, SomeSite("s", 50.0, 8.0)), StorageError);
  CHECK_THROWS_AS(silent.claims.ClaimNext(), StorageError);
  CHECK_FALSE(silent.claims.Renew());
  CHECK(other.claims.Renew());
  CHECK(other.frames.Find("f", "1")->state == FrameState::kQueued);
  CHECK_FALSE(other.sites.Find("s"));
}

TEST_CASE("claims: a worker that renews its lease keeps its flights") {
  const StoragePlace place;
  Storage one(AsWorker(place.OptionsOfOne()));
  Storage other(AsWorker(place.OptionsOfOther()));
  one.images.Write(kImage, "pixels");
  InsertFlightWithFrame(one, "f");
  CHECK(one.claims.ClaimNext());
  EndLeases(place);
  CHECK(one.claims.Renew());
  CHECK_FALSE(other.claims.ClaimNext());
  EndLeases(place);
  CHECK(other.claims.ClaimNext());
  CHECK_FALSE(one.claims.Renew());
}

TEST_CASE("claims: a write that a silent worker has begun is ended, so nobody waits for it") {
  const StoragePlace place;
  Storage silent(AsWorker(place.OptionsOfOne()));
  Storage other(AsWorker(place.OptionsOfOther()));
  silent.images.Write(kImage, "pixels");
  InsertFlightWithFrame(silent, "f");
  CHECK(silent.claims.ClaimNext());
  EndLeases(place);
  std::unique_ptr<SiteTurn> turn = silent.sites.TakeTurn();
  const std::optional<Claim> taken = ClaimWithin(other, std::chrono::seconds(5));
  REQUIRE(taken);
  CHECK(taken->num_lost == 1);
  CHECK_THROWS_AS(turn->PutEvaluation({{SomeSite("s", 50.0, 8.0)}, {}, {}, {}}, {}), StorageError);
  CHECK_FALSE(other.sites.Find("s"));
}

TEST_CASE("claims: leases and waiting flights are counted for the operator") {
  const StoragePlace place;
  Storage one(AsWorker(place.OptionsOfOne()));
  Storage other(AsWorker(place.OptionsOfOther()));
  one.images.Write(kImage, "pixels");
  InsertFlightWithFrame(one, "f");
  InsertFlightWithFrame(one, "g");
  CHECK(one.claims.ClaimNext());
  EndLeases(place);
  const LeaseCounts counts = other.claims.CountLeases();
  CHECK(counts.num_workers == 1);
  CHECK(counts.num_expired_workers == 1);
  CHECK(counts.num_claimed_flights == 1);
  CHECK(counts.num_waiting_flights == 1);
}

TEST_CASE("shared: a frame that another server has stored meanwhile is a conflict") {
  const StoragePlace place;
  Storage one(place.OptionsOfOne());
  one.images.Write(kImage, "pixels");
  InsertFlightWithFrame(one, "f");
  const StorageFault fault = [&] {
    try {
      one.frames.Insert("f", {SomeFrame("f", "1")});
    } catch (const StorageError& error) {
      return error.fault;
    }
    return StorageFault::kOther;
  }();
  CHECK(fault == StorageFault::kConflict);
  CHECK(one.frames.List("f").size() == 1);
}

TEST_CASE("claims: a worker that ends in order gives its flights back without a mark") {
  const StoragePlace place;
  Storage other(AsWorker(place.OptionsOfOther()));
  other.images.Write(kImage, "pixels");
  InsertFlightWithFrame(other, "f");
  {
    Storage one(AsWorker(place.OptionsOfOne()));
    CHECK(one.claims.ClaimNext());
  }
  const std::optional<Claim> taken = other.claims.ClaimNext();
  REQUIRE(taken);
  CHECK(taken->num_lost == 0);
}

TEST_CASE("claims: workers in a row that end without a word are counted") {
  const StoragePlace place;
  Storage sender(place.OptionsOfOne());
  sender.images.Write(kImage, "pixels");
  InsertFlightWithFrame(sender, "f");
  std::vector<std::unique_ptr<Storage>> silent;
  for (int i = 0; i < 4; ++i) {
    StorageOptions options = AsWorker(place.OptionsOfOther());
    options.folder /= std::to_string(i);
    silent.push_back(std::make_unique<Storage>(options));
    const std::optional<Claim> taken = silent.back()->claims.ClaimNext();
    REQUIRE(taken);
    CHECK(taken->num_lost == i);
    EndLeases(place);
  }
}

TEST_CASE("claims: a flight that went on meanwhile has ended no worker") {
  const StoragePlace place;
  Storage one(AsWorker(place.OptionsOfOne()));
  Storage other(AsWorker(place.OptionsOfOther()));
  one.images.Write(kImage, "pixels");
  InsertFlightWithFrame(one, "f");
  CHECK(one.claims.ClaimNext());
  EndLeases(place);
  CHECK(other.claims.ClaimNext()->num_lost == 1);
  other.frames.SetState("f", "1", FrameState::kProcessed, "");
  other.frames.SetState("f", "1", FrameState::kQueued, "");
  EndLeases(place);
  StorageOptions third = AsWorker(place.OptionsOfOther());
  third.folder /= "third";
  CHECK(Storage(third).claims.ClaimNext()->num_lost == 1);
}

TEST_CASE("claims: who is no worker claims nothing") {
  const StoragePlace place;
  Storage storage(place.OptionsOfOne());
  storage.images.Write(kImage, "pixels");
  InsertFlightWithFrame(storage, "f");
  CHECK(storage.claims.IsShared());
  CHECK_FALSE(storage.claims.ClaimNext());
  CHECK(storage.claims.Renew());
}

TEST_CASE("claims: events of others are told once, in the order of their numbers") {
  constexpr int kNumEvents = 30;
  const StoragePlace place;
  Storage one(place.OptionsOfOne());
  Storage other(place.OptionsOfOther());
  StorageOptions options = place.OptionsOfOne();
  options.folder = options.folder / "listener";
  Storage listener(options);
  std::vector<std::thread> threads;
  for (Storage* storage : {&one, &other}) {
    threads.emplace_back([storage] {
      for (int i = 0; i < kNumEvents; ++i) storage->claims.Tell({0, "frame", "f", "{}"});
    });
  }
  std::vector<SharedEvent> told;
  int64_t last = 0;
  while (told.size() < 2 * kNumEvents) {
    for (const SharedEvent& event : listener.claims.ListTold(last, 7)) {
      CHECK(event.number == last + 1);
      last = event.number;
      told.push_back(event);
    }
  }
  for (std::thread& thread : threads) thread.join();
  CHECK(told.size() == 2 * kNumEvents);
  CHECK(one.claims.ListTold(0, 100).size() == kNumEvents);
  CHECK(listener.claims.LastTold() == last);
  listener.claims.ForgetOldTold();
  CHECK(listener.claims.ListTold(0, 100).size() == 2 * kNumEvents);
  place.Execute("UPDATE told_events SET told_at = now() - interval '11 minutes'");
  listener.claims.ForgetOldTold();
  CHECK(listener.claims.ListTold(0, 100).empty());
}

}  // namespace
}  // namespace freelsd

TEST_SUITE_END();
