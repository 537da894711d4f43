#include <limits>

#include "storage/stores/stores.h"

namespace freelsd {
namespace {

JobRow JobRowOf(const Row& row) {
  JobRow job;
  job.id = row.Text(0);
  job.kind = row.Text(1);
  job.flight_id = row.Text(2);
  job.state = static_cast<JobState>(row.Int(3));
  job.progress_ratio = row.Real(4);
  job.stage = row.Text(5);
  job.detail_json = row.Text(6);
  job.created_at_us = row.Int(7);
  job.number = row.Int(8);
  return job;
}

std::string SelectJobs(const std::string& which) {
  return "SELECT id, kind, flight_id, state, progress_ratio, stage, detail_json, created_at_us, "
         "number FROM jobs " +
         which;
}

}  // namespace

void InsertJobRow(Database& writer, const JobRow& job) {
  writer.Change(
      "INSERT INTO jobs (id, kind, flight_id, state, progress_ratio, stage, detail_json, "
      "created_at_us) VALUES ($1, $2, $3, $4, $5, $6, $7, $8)",
      job.id,
      job.kind,
      job.flight_id,
      static_cast<int>(job.state),
      job.progress_ratio,
      job.stage,
      job.detail_json,
      job.created_at_us);
}

void SqlJobStore::Insert(const JobRow& job) {
  access_.Write([&](Writer& writer) { InsertJobRow(*writer, job); });
}

bool SqlJobStore::InsertAlone(const JobRow& job) {
  return access_.Write([&](Writer& writer) {
    LockFlight(*writer, job.flight_id);
    const bool is_another_unfinished =
        writer->Has("SELECT 1 FROM jobs WHERE flight_id = $1 AND kind = $2 AND state < 2 LIMIT 1",
                    job.flight_id,
                    job.kind);
    if (!is_another_unfinished) InsertJobRow(*writer, job);
    return !is_another_unfinished;
  });
}

void SqlJobStore::Update(const JobRow& job) {
  access_.Write([&](Writer& writer) {
    writer->Change(
        "UPDATE jobs SET state = $2, progress_ratio = $3, stage = $4, detail_json = $5 "
        "WHERE id = $1 AND state < 2",
        job.id,
        static_cast<int>(job.state),
        job.progress_ratio,
        job.stage,
        job.detail_json);
  });
}

std::optional<JobRow> SqlJobStore::Find(const std::string& job_id) const {
  return access_.Read([&](Database& database) {
    return database.First(JobRowOf, SelectJobs("WHERE id = $1"), job_id);
  });
}

JobPage SqlJobStore::ListPage(size_t limit,
                              std::optional<int64_t> before_number,
                              size_t max_bytes) const {
  // Details may be large: no more are read than the page may hold, and these.
  constexpr size_t kNumAtOnce = 16;
  return access_.Read([&](Database& database) {
    JobPage page;
    size_t num_bytes = 0;
    int64_t before = before_number.value_or(std::numeric_limits<int64_t>::max());
    while (true) {
      std::vector<JobRow> jobs =
          database.Each(JobRowOf,
                        SelectJobs("WHERE number < $1 ORDER BY number DESC LIMIT $2"),
                        before,
                        static_cast<int64_t>(kNumAtOnce));
      for (JobRow& job : jobs) {
        page.has_more = page.jobs.size() == limit || num_bytes > max_bytes;
        if (page.has_more) return page;
        num_bytes += job.detail_json.size();
        page.jobs.push_back(std::move(job));
      }
      if (jobs.size() < kNumAtOnce) return page;
      before = jobs.back().number;
    }
  });
}

std::vector<JobRow> SqlJobStore::ListOf(const std::string& flight_id) const {
  return access_.Read([&](Database& database) {
    return database.Each(
        JobRowOf, SelectJobs("WHERE flight_id = $1 ORDER BY number DESC"), flight_id);
  });
}

std::vector<JobRow> SqlJobStore::ListUnfinished() const {
  return access_.Read([](Database& database) {
    return database.Each(JobRowOf, SelectJobs("WHERE state < 2 ORDER BY number"));
  });
}

bool SqlJobStore::Delete(const std::string& job_id) {
  return access_.Write(
      [&](Writer& writer) { return writer->Change("DELETE FROM jobs WHERE id = $1", job_id) > 0; });
}

}  // namespace freelsd
