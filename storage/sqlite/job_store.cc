#include <limits>

#include "storage/sqlite/job_rows.h"
#include "storage/sqlite/state.h"
#include "storage/sqlite/stores.h"

namespace freelsd {
namespace {

JobRow JobRowOf(const Statement& statement) {
  JobRow job;
  job.id = statement.Text(0);
  job.kind = statement.Text(1);
  job.flight_id = statement.Text(2);
  job.state = static_cast<JobState>(statement.Int(3));
  job.progress_ratio = statement.Real(4);
  job.stage = statement.Text(5);
  job.detail_json = statement.Text(6);
  job.created_at_us = statement.Int(7);
  job.number = statement.Int(8);
  return job;
}

Statement SelectJobs(const Connection& connection, const std::string& which) {
  constexpr char kSelect[] =
      "SELECT id, kind, flight_id, state, progress_ratio, stage, detail_json, created_at_us, "
      "number FROM jobs ";
  return connection.Prepare((kSelect + which).c_str());
}

std::vector<JobRow> RowsOf(Statement& statement) {
  std::vector<JobRow> jobs;
  while (statement.Step()) jobs.push_back(JobRowOf(statement));
  return jobs;
}

}  // namespace

void InsertJobRow(const Connection& writer, const JobRow& job) {
  writer
      .Prepare(
          "INSERT INTO jobs (id, kind, flight_id, state, progress_ratio, stage, detail_json, "
          "created_at_us) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)")
      .Bind(job.id,
            job.kind,
            job.flight_id,
            static_cast<int>(job.state),
            job.progress_ratio,
            job.stage,
            job.detail_json,
            job.created_at_us)
      .Run();
}

void SqliteJobStore::Insert(const JobRow& job) {
  const auto lock = state_.LockForWriting();
  InsertJobRow(state_.writer, job);
}

bool SqliteJobStore::InsertAlone(const JobRow& job) {
  const auto lock = state_.LockForWriting();
  Statement unfinished =
      state_.writer.Prepare("SELECT 1 FROM jobs WHERE flight_id = ?1 AND kind = ?2 AND state < 2");
  if (unfinished.Bind(job.flight_id, job.kind).Step()) return false;
  InsertJobRow(state_.writer, job);
  return true;
}

void SqliteJobStore::Update(const JobRow& job) {
  const auto lock = state_.LockForWriting();
  state_.writer
      .Prepare(
          "UPDATE jobs SET state = ?2, progress_ratio = ?3, stage = ?4, detail_json = ?5 "
          "WHERE id = ?1 AND state < 2")
      .Bind(job.id, static_cast<int>(job.state), job.progress_ratio, job.stage, job.detail_json)
      .Run();
}

std::optional<JobRow> SqliteJobStore::Find(const std::string& job_id) const {
  const Reader reader(state_.readers);
  Statement statement = SelectJobs(*reader, "WHERE id = ?1");
  if (!statement.Bind(job_id).Step()) return std::nullopt;
  return JobRowOf(statement);
}

JobPage SqliteJobStore::ListPage(size_t limit,
                                 std::optional<int64_t> before_number,
                                 size_t max_bytes) const {
  const Reader reader(state_.readers);
  Statement statement = SelectJobs(*reader, "WHERE number < ?1 ORDER BY number DESC");
  statement.Bind(before_number.value_or(std::numeric_limits<int64_t>::max()));
  JobPage page;
  size_t num_bytes = 0;
  while (statement.Step()) {
    page.has_more = page.jobs.size() == limit || num_bytes > max_bytes;
    if (page.has_more) break;
    page.jobs.push_back(JobRowOf(statement));
    num_bytes += page.jobs.back().detail_json.size();
  }
  return page;
}

std::vector<JobRow> SqliteJobStore::ListOf(const std::string& flight_id) const {
  const Reader reader(state_.readers);
  Statement statement = SelectJobs(*reader, "WHERE flight_id = ?1 ORDER BY number DESC");
  return RowsOf(statement.Bind(flight_id));
}

std::vector<JobRow> SqliteJobStore::ListUnfinished() const {
  const Reader reader(state_.readers);
  Statement statement = SelectJobs(*reader, "WHERE state < 2 ORDER BY number");
  return RowsOf(statement);
}

bool SqliteJobStore::Delete(const std::string& job_id) {
  const auto lock = state_.LockForWriting();
  state_.writer.Prepare("DELETE FROM jobs WHERE id = ?1").Bind(job_id).Run();
  return state_.writer.NumChanges() > 0;
}

}  // namespace freelsd
