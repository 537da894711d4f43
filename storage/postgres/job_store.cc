#include <limits>

#include "storage/postgres/flight_rows.h"
#include "storage/postgres/job_rows.h"
#include "storage/postgres/state.h"
#include "storage/postgres/stores.h"

namespace freelsd {
namespace {

constexpr char kSelectJobs[] =
    "SELECT id, kind, flight_id, state, progress_ratio, stage, detail_json, created_at_us, "
    "number FROM jobs ";

JobRow JobRowOf(const PostgresRow& row) {
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

bool HasOlderJob(PostgresState& state, const JobRow& job) {
  return state.Read([&](PostgresConnection& connection) {
    return connection.Run("SELECT EXISTS (SELECT 1 FROM jobs WHERE number < $1)", job.number)[0]
        .Bool(0);
  });
}

}  // namespace

void InsertJob(PostgresConnection& writer, const JobRow& job) {
  writer.Run(
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

void PostgresJobStore::Insert(const JobRow& job) {
  PostgresWrite writer(state_);
  InsertJob(*writer, job);
  writer.Commit();
}

bool PostgresJobStore::InsertAlone(const JobRow& job) {
  PostgresWrite writer(state_);
  LockFlight(*writer, job.flight_id);
  const PostgresRows unfinished =
      writer->Run("SELECT 1 FROM jobs WHERE flight_id = $1 AND kind = $2 AND state < 2 LIMIT 1",
                  job.flight_id,
                  job.kind);
  if (!unfinished.empty()) return false;
  InsertJob(*writer, job);
  writer.Commit();
  return true;
}

void PostgresJobStore::Update(const JobRow& job) {
  PostgresWrite writer(state_);
  writer->Run(
      "UPDATE jobs SET state = $2, progress_ratio = $3, stage = $4, detail_json = $5 "
      "WHERE id = $1 AND state < 2",
      job.id,
      static_cast<int>(job.state),
      job.progress_ratio,
      job.stage,
      job.detail_json);
  writer.Commit();
}

std::optional<JobRow> PostgresJobStore::Find(const std::string& job_id) const {
  return state_.Read([&](PostgresConnection& connection) -> std::optional<JobRow> {
    const PostgresRows rows = connection.Run(std::string(kSelectJobs) + "WHERE id = $1", job_id);
    if (rows.empty()) return std::nullopt;
    return JobRowOf(rows[0]);
  });
}

JobPage PostgresJobStore::ListPage(size_t limit,
                                   std::optional<int64_t> before_number,
                                   size_t max_bytes) const {
  // The sum before a row counts the rows before it: the row that exceeds is the last one.
  JobPage page;
  page.jobs = state_.Read([&](PostgresConnection& connection) {
    return connection
        .Run(
            "SELECT id, kind, flight_id, state, progress_ratio, stage, detail_json, "
            "created_at_us, number FROM (SELECT *, coalesce(sum(octet_length(detail_json)) OVER "
            "(ORDER BY number DESC ROWS BETWEEN UNBOUNDED PRECEDING AND 1 PRECEDING), 0) AS "
            "num_bytes_before FROM (SELECT * FROM jobs WHERE number < $1 ORDER BY number DESC "
            "LIMIT $2) AS newest) AS page WHERE num_bytes_before <= $3 ORDER BY number DESC",
            before_number.value_or(std::numeric_limits<int64_t>::max()),
            static_cast<int64_t>(limit) + 1,
            static_cast<int64_t>(max_bytes))
        .Each(JobRowOf);
  });
  page.has_more = page.jobs.size() > limit;
  if (page.has_more) page.jobs.pop_back();
  if (!page.has_more && !page.jobs.empty()) page.has_more = HasOlderJob(state_, page.jobs.back());
  return page;
}

std::vector<JobRow> PostgresJobStore::ListOf(const std::string& flight_id) const {
  return state_.Read([&](PostgresConnection& connection) {
    return connection
        .Run(std::string(kSelectJobs) + "WHERE flight_id = $1 ORDER BY number DESC", flight_id)
        .Each(JobRowOf);
  });
}

std::vector<JobRow> PostgresJobStore::ListUnfinished() const {
  return state_.Read([](PostgresConnection& connection) {
    return connection.Run(std::string(kSelectJobs) + "WHERE state < 2 ORDER BY number")
        .Each(JobRowOf);
  });
}

bool PostgresJobStore::Delete(const std::string& job_id) {
  PostgresWrite writer(state_);
  const bool was_there = writer->Run("DELETE FROM jobs WHERE id = $1", job_id).NumChanges() > 0;
  writer.Commit();
  return was_there;
}

}  // namespace freelsd
