#include "storage/job_store.h"

#include <doctest/doctest.h>

#include "storage/storage.h"
#include "tests/storage/rows.h"

namespace freelsd {
namespace {

TEST_CASE("job store: a finished job is not changed any more") {
  const TemporaryFolder folder;
  Storage storage(folder.path());
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
  CHECK(storage.jobs.List().size() == 1);
  CHECK(storage.jobs.Delete("j"));
}

}  // namespace
}  // namespace freelsd
