// A PostgreSQL database that breaks, or is not the right one.
#include <atomic>
#include <chrono>
#include <cstdlib>
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

// pg_ctl of the suite's own cluster.
void ControlCluster(const std::string& command) {
  const char* const control = std::getenv("FREELSD_TEST_CLUSTER");
  REQUIRE(control != nullptr);
  REQUIRE(std::system((control + (" " + command) + " >/dev/null 2>&1").c_str()) == 0);
}

TEST_CASE("postgres: a schema of another number is refused with a sentence, and stays as it is") {
  for (const std::string number : {"7", "9", "99"}) {
    CAPTURE(number);
    const StoragePlace place;
    { Storage(place.options()).flights.Insert(SomeFlight("f")); }
    const std::string content = place.Content();
    place.Execute("UPDATE schema_migrations SET version = " + number);
    const std::string before = place.Content();
    CHECK(before != content);
    try {
      const Storage storage(place.options());
      FAIL("it was opened");
    } catch (const StorageError& error) {
      const std::string text = error.what();
      CHECK(error.fault == StorageFault::kOtherSchema);
      CHECK(text.find("schema number " + number) != std::string::npos);
      CHECK(text.find("number 8 only") != std::string::npos);
      CHECK(text.find("POST the photographs of each flight again") != std::string::npos);
    }
    CHECK(place.Content() == before);
    place.Execute("UPDATE schema_migrations SET version = 8");
    CHECK(place.Content() == content);
    CHECK(Storage(place.options()).flights.Find("f"));
  }
}

TEST_CASE("postgres: a second process is refused unless the database is shared") {
  const StoragePlace place;
  const Storage storage(place.options());
  StorageOptions other = place.OptionsOfOther();
  other.is_shared = false;
  CHECK_THROWS_WITH_AS(
      Storage{other}, doctest::Contains("another freelsd-server uses it"), StorageError);
}

TEST_CASE("postgres: who shares a database and who wants it alone exclude each other") {
  const StoragePlace place;
  StorageOptions alone = place.OptionsOfOther();
  alone.is_shared = false;
  {
    Storage one(place.OptionsOfOne());
    CHECK_THROWS_WITH_AS(
        Storage{alone}, doctest::Contains("another freelsd-server uses it"), StorageError);
    // Its lock is gone with its connections, and the other one comes.
    place.Execute(
        "SELECT pg_terminate_backend(pid) FROM pg_stat_activity "
        "WHERE application_name = 'freelsd'");
    const Storage other(alone);
    CHECK_THROWS_WITH_AS(one.flights.Insert(SomeFlight("f")),
                         doctest::Contains("took the database over"),
                         StorageError);
    CHECK_THROWS_WITH_AS(Storage{[&place] {
                           StorageOptions third = place.OptionsOfOne();
                           third.folder /= "third";
                           return third;
                         }()},
                         doctest::Contains("another freelsd-server uses it"),
                         StorageError);
  }
  CHECK_NOTHROW(Storage{place.OptionsOfOne()});
}

TEST_CASE("postgres: a process writes nothing after another one took the database from it") {
  const StoragePlace place;
  Storage storage(place.options());
  storage.flights.Insert(SomeFlight("f"));
  // Its lock is gone with its connections.
  place.Execute(
      "SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE application_name = 'freelsd'");
  StorageOptions options = place.OptionsOfOther();
  options.is_shared = false;
  Storage other(options);
  other.flights.Insert(SomeFlight("g"));
  CHECK_THROWS_WITH_AS(storage.flights.Insert(SomeFlight("h")),
                       doctest::Contains("took the database over"),
                       StorageError);
  CHECK(storage.WhyNotWritable());
  CHECK(other.flights.Count() == 2);
  CHECK_FALSE(other.WhyNotWritable());
}

TEST_CASE("postgres: who had a database alone writes nothing after others began to share it") {
  const StoragePlace place;
  StorageOptions alone = place.OptionsOfOne();
  alone.is_shared = false;
  Storage storage(alone);
  place.Execute(
      "SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE application_name = 'freelsd'");
  Storage other(place.OptionsOfOther());
  StorageOptions third = place.OptionsOfOther();
  third.folder /= "third";
  Storage another(third);
  CHECK_THROWS_WITH_AS(storage.flights.Insert(SomeFlight("f")),
                       doctest::Contains("took the database over"),
                       StorageError);
  CHECK_NOTHROW(other.flights.Insert(SomeFlight("g")));
  CHECK_NOTHROW(another.flights.Insert(SomeFlight("h")));
}

TEST_CASE("postgres: two processes create the schema at the same time, once") {
  const StoragePlace place;
  std::atomic<int> num_open{0};
  std::vector<std::thread> threads;
  for (const StorageOptions& options : {place.OptionsOfOne(), place.OptionsOfOther()}) {
    threads.emplace_back([&num_open, options] {
      const Storage storage(options);
      ++num_open;
    });
  }
  for (std::thread& thread : threads) thread.join();
  CHECK(num_open == 2);
}

TEST_CASE("postgres: a URI with a password is refused without telling it") {
  const StoragePlace place;
  StorageOptions options = place.options();
  options.database_url = "postgresql://someone:secret@localhost/freelsd";
  try {
    const Storage storage(options);
    FAIL("it was opened");
  } catch (const StorageError& error) {
    CHECK(std::string(error.what()).find("password") != std::string::npos);
    CHECK(std::string(error.what()).find("secret") == std::string::npos);
  }
}

TEST_CASE("postgres: a database that cannot be reached is an error within the time") {
  const StoragePlace place;
  StorageOptions options = place.options();
  options.database_url = "postgresql://someone@localhost:1/freelsd";
  options.connection_timeout_s = 1.0;
  const auto before = std::chrono::steady_clock::now();
  CHECK_THROWS_AS(Storage{options}, StorageError);
  CHECK(std::chrono::steady_clock::now() - before < std::chrono::seconds(10));
}

TEST_CASE("postgres: connections that the server ends are replaced") {
  const StoragePlace place;
  Storage storage(place.options());
  storage.flights.Insert(SomeFlight("f"));
  for (int i = 0; i < 3; ++i) {
    place.Execute(
        "SELECT pg_terminate_backend(pid) FROM pg_stat_activity "
        "WHERE application_name = 'freelsd'");
    CHECK(storage.flights.Find("f"));
    CHECK(storage.flights.Change("f", [](FlightRow& flight) { ++flight.num_rejected_frames; }));
    CHECK_FALSE(storage.WhyNotWritable());
  }
  CHECK(storage.flights.Find("f")->num_rejected_frames == 3);
}

TEST_CASE("postgres: a statement that waits too long is given up") {
  const StoragePlace place;
  StorageOptions options = place.options();
  options.statement_timeout_s = 0.5;
  Storage storage(options);
  storage.flights.Insert(SomeFlight("f"));
  std::thread holder(
      [&place] { place.Execute("BEGIN; LOCK TABLE flights; SELECT pg_sleep(3); COMMIT"); });
  std::this_thread::sleep_for(std::chrono::seconds(1));
  CHECK_THROWS_WITH_AS(storage.flights.Insert(SomeFlight("g")),
                       doctest::Contains("statement timeout"),
                       StorageError);
  holder.join();
  storage.flights.Insert(SomeFlight("g"));
  CHECK(storage.flights.Count() == 2);
}

TEST_CASE("postgres: after MarkDamaged nothing is written, and the reason is told") {
  const StoragePlace place;
  Storage storage(place.options());
  storage.MarkDamaged("site s: its map cannot be read");
  CHECK_THROWS_AS(storage.flights.Insert(SomeFlight("f")), StorageError);
  CHECK(storage.WhyNotWritable());
  REQUIRE_FALSE(storage.Notices().empty());
  CHECK(storage.Notices().back().find("site s") != std::string::npos);
}

TEST_CASE("postgres: the suite's own cluster is durable, so there is no notice") {
  const StoragePlace place;
  CHECK(Storage(place.options()).Notices().empty());
}

// Frames are stored while the cluster is stopped without a checkpoint and started again.
TEST_CASE("postgres: no frame whose insert returned is lost by immediate shutdowns") {
  constexpr int kNumShutdowns = 3;
  const StoragePlace place;
  Storage storage(place.options());
  storage.flights.Insert(SomeFlight("f"));
  storage.images.Write(kImage, "pixels");
  std::atomic<bool> is_over{false};
  std::vector<std::string> acknowledged;
  int num_failed = 0;
  std::thread sender([&] {
    for (int i = 0; !is_over; ++i) {
      try {
        storage.frames.Insert("f", {SomeFrame("f", std::to_string(i))});
        acknowledged.push_back(std::to_string(i));
      } catch (const StorageError&) {
        ++num_failed;
      }
    }
  });
  for (int i = 0; i < kNumShutdowns; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    ControlCluster("stop -m immediate");
    ControlCluster("start");
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  is_over = true;
  sender.join();
  MESSAGE(acknowledged.size() << " frames acknowledged, " << num_failed << " inserts failed");
  CHECK(acknowledged.size() > 10);
  for (const std::string& id : acknowledged) {
    CAPTURE(id);
    CHECK(storage.frames.Find("f", id));
  }
  const std::vector<FrameRow> frames = storage.frames.List("f");
  for (size_t i = 0; i < frames.size(); ++i) {
    CHECK(frames[i].sequence == static_cast<int64_t>(i) + 1);
  }
}

}  // namespace
}  // namespace freelsd

TEST_SUITE_END();
