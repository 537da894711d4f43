#include "storage/job_store.h"

#include <doctest/doctest.h>

#include "storage/storage.h"
#include "tests/storage/place.h"
#include "tests/storage/rows.h"

namespace freelsd {
namespace {

TEST_CASE("job store: a finished job is not changed any more") {
  const StoragePlace place;
  Storage storage(place.options());
  storage.flights.Insert(SomeFlight("f"));
  JobRow job = SomeJob("j", "f");
  storage.jobs.Insert(job);
  CHECK(storage.jobs.ListUnfinished().size() == 1);
  job.state = JobState::kCancelled;
  storage.jobs.Update(job);
  job.state = JobState::kDone;
  storage.jobs.Update(job);
  CHECK(storage.jobs.Find("j")->state == JobState::kCancelled);
  CHECK(storage.jobs.ListUnfinished().empty());
  CHECK(storage.jobs.ListPage(10, std::nullopt, 1000).jobs.size() == 1);
  CHECK(storage.jobs.Delete("j"));
}

TEST_CASE("job store: of one kind, a flight has one unfinished job") {
  const StoragePlace place;
  Storage storage(place.options());
  storage.flights.Insert(SomeFlight("f"));
  JobRow job = SomeJob("one", "f");
  CHECK(storage.jobs.InsertAlone(job));
  CHECK_FALSE(storage.jobs.InsertAlone(SomeJob("other", "f")));
  CHECK(storage.jobs.ListOf("f").size() == 1);
  job.state = JobState::kDone;
  storage.jobs.Update(job);
  CHECK(storage.jobs.InsertAlone(SomeJob("other", "f")));
}

TEST_CASE("job store: pages list every job once, newest first, and end early for large details") {
  const StoragePlace place;
  Storage storage(place.options());
  storage.flights.Insert(SomeFlight("f"));
  for (int i = 0; i < 5; ++i) {
    JobRow job = SomeJob("j" + std::to_string(i), "f");
    job.detail_json.insert(0, 100, ' ');
    storage.jobs.Insert(job);
  }
  const JobPage first = storage.jobs.ListPage(3, std::nullopt, 100000);
  REQUIRE(first.jobs.size() == 3);
  CHECK(first.has_more);
  CHECK(first.jobs[0].id == "j4");
  const JobPage second = storage.jobs.ListPage(3, first.jobs[2].number, 100000);
  REQUIRE(second.jobs.size() == 2);
  CHECK_FALSE(second.has_more);
  CHECK(second.jobs[1].id == "j0");
  const JobPage short_page = storage.jobs.ListPage(3, std::nullopt, 50);
  CHECK(short_page.jobs.size() == 1);
  CHECK(short_page.has_more);
}

TEST_CASE("job store: pages hold more jobs than are read at once") {
  constexpr int kNumJobs = 40;
  const StoragePlace place;
  Storage storage(place.options());
  storage.flights.Insert(SomeFlight("f"));
  for (int i = 0; i < kNumJobs; ++i) storage.jobs.Insert(SomeJob(std::to_string(i), "f"));
  const JobPage all = storage.jobs.ListPage(kNumJobs, std::nullopt, 100000);
  REQUIRE(all.jobs.size() == kNumJobs);
  CHECK_FALSE(all.has_more);
  for (size_t i = 0; i < all.jobs.size(); ++i) {
    CHECK(all.jobs[i].id == std::to_string(kNumJobs - 1 - i));
  }
  const JobPage half = storage.jobs.ListPage(32, std::nullopt, 100000);
  CHECK(half.jobs.size() == 32);
  CHECK(half.has_more);
}

}  // namespace
}  // namespace freelsd
