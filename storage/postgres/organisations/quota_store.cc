#include "storage/quota_store.h"

#include <algorithm>

#include "storage/postgres/state.h"
#include "storage/postgres/stores.h"

namespace freelsd {
namespace {

struct Usage {
  double num_image_bytes = 0.0;
  double frame_allowance = 0.0;
  double num_unfinished_jobs = 0.0;
};

// Locks the row: requests to all servers take turns.
Usage LockUsage(PostgresConnection& writer, double max_frames_per_minute) {
  const PostgresRows rows = writer.Run(
      "SELECT num_image_bytes::float8, CASE WHEN allowed_at = '-infinity' THEN $1 ELSE least($1, "
      "frame_allowance + $1 / 60 * extract(epoch FROM clock_timestamp() - allowed_at)::float8) "
      "END, "
      "(SELECT count(*) FROM jobs WHERE state < 2)::float8 "
      "FROM organisation_usage WHERE organisation = current_setting('freelsd.organisation') "
      "FOR UPDATE OF organisation_usage",
      max_frames_per_minute);
  if (rows.empty()) throw StorageError("read the organisation's usage", "its row is missing");
  return {rows[0].Real(0), rows[0].Real(1), rows[0].Real(2)};
}

std::optional<QuotaRefusal> RefusalOf(const Quotas& quotas,
                                      const QuotaDemand& demand,
                                      const Usage& usage) {
  const double num_bytes = usage.num_image_bytes + static_cast<double>(demand.num_image_bytes);
  if (demand.num_image_bytes > 0 && quotas.max_num_image_bytes &&
      num_bytes > static_cast<double>(*quotas.max_num_image_bytes)) {
    return QuotaRefusal{
        Quota::kImageBytes, static_cast<double>(*quotas.max_num_image_bytes), num_bytes, 0.0};
  }
  const double num_jobs = usage.num_unfinished_jobs + static_cast<double>(demand.num_jobs);
  if (demand.num_jobs > 0 && quotas.max_num_unfinished_jobs &&
      num_jobs > static_cast<double>(*quotas.max_num_unfinished_jobs)) {
    return QuotaRefusal{
        Quota::kJobs, static_cast<double>(*quotas.max_num_unfinished_jobs), num_jobs, 0.0};
  }
  if (demand.num_frames == 0 || !quotas.max_frames_per_minute) return std::nullopt;
  const double rate = *quotas.max_frames_per_minute;
  const double wanted = std::min(static_cast<double>(demand.num_frames), rate);
  if (usage.frame_allowance >= wanted) return std::nullopt;
  return QuotaRefusal{Quota::kFrames,
                      rate,
                      rate - usage.frame_allowance + static_cast<double>(demand.num_frames),
                      (wanted - usage.frame_allowance) * 60.0 / rate};
}

}  // namespace

std::optional<QuotaRefusal> PostgresQuotaStore::Admit(const Quotas& quotas,
                                                      const QuotaDemand& demand) {
  if (!quotas.max_num_image_bytes && !quotas.max_frames_per_minute &&
      !quotas.max_num_unfinished_jobs) {
    return std::nullopt;
  }
  PostgresWrite writer(state_);
  const Usage usage = LockUsage(*writer, quotas.max_frames_per_minute.value_or(0.0));
  const std::optional<QuotaRefusal> refusal = RefusalOf(quotas, demand, usage);
  if (refusal || demand.num_frames == 0 || !quotas.max_frames_per_minute) return refusal;
  writer->Run(
      "UPDATE organisation_usage SET frame_allowance = $1, allowed_at = clock_timestamp() "
      "WHERE organisation = current_setting('freelsd.organisation')",
      usage.frame_allowance - static_cast<double>(demand.num_frames));
  writer.Commit();
  return std::nullopt;
}

}  // namespace freelsd
