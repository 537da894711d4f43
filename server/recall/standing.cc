#include "server/recall/standing.h"

#include <algorithm>
#include <optional>
#include <tuple>
#include <utility>

#include <spdlog/spdlog.h>

#include "server/http/http.h"

namespace freelsd {
namespace {

Standing Undoubted(Standing standing) {
  standing.superseded_by_map.clear();
  standing.superseded_at_us = 0;
  standing.superseded_reason.clear();
  standing.superseded_detail.clear();
  return standing;
}

// True if a failure, or a doubt of a site that is not superseded, takes the place of the present
// one. A map whose order is not known (since 0) supersedes only if no later one does. Its doubt
// outlasts those that a later map may settle.
bool IsStronger(const Standing& standing,
                bool is_doubt,
                int64_t since_us,
                const std::string& map_id) {
  if (standing.superseded_reason.empty()) return true;
  if (standing.IsDoubted() != is_doubt) return !is_doubt;
  if (is_doubt && (standing.superseded_at_us == 0) != (since_us == 0)) return since_us == 0;
  return std::tie(standing.superseded_at_us, standing.superseded_by_map) <
         std::tie(since_us, map_id);
}

void Report(MapCache& maps, const std::string& site_id, const Standing& standing) {
  if (standing.superseded_by) maps.DropPlans(site_id);
  if (standing.superseded_reason.empty()) return;
  spdlog::info("site {} is {} by {}: {}: {}",
               site_id,
               standing.IsDoubted()     ? "doubted"
               : standing.IsContested() ? "contested"
                                        : "superseded",
               standing.JudgeId(),
               standing.superseded_reason,
               standing.superseded_detail);
}

}  // namespace

Standing With(Standing standing,
              const PlanCheck& check,
              const MapRow& map,
              const std::string& shown_id,
              bool is_later) {
  if (check.verdict == PlanVerdict::kHolds) {
    standing.confirmed_at_us =
        std::max(standing.confirmed_at_us.value_or(map.seen_at_us), map.seen_at_us);
    const bool is_settled = standing.IsDoubted() && standing.superseded_at_us > 0 &&
                            standing.superseded_at_us < *standing.confirmed_at_us;
    return is_settled ? Undoubted(std::move(standing)) : standing;
  }
  const bool is_doubt = check.verdict == PlanVerdict::kDoubts;
  if (check.verdict != PlanVerdict::kFails && !is_doubt) return standing;
  // A map that confirms may be later than a doubt only if both times are exact.
  const bool is_dated = is_later && !(is_doubt && map.seen_until_us);
  const int64_t since_us = is_dated ? map.seen_at_us : 0;
  const bool is_settled = is_dated && since_us < standing.confirmed_at_us.value_or(0);
  if (is_doubt && (standing.superseded_by || is_settled)) return standing;
  if (!IsStronger(standing, is_doubt, since_us, map.id)) return standing;
  standing.superseded_by = is_doubt ? std::nullopt : std::optional(shown_id);
  standing.superseded_by_map = map.id;
  standing.superseded_at_us = since_us;
  standing.superseded_reason = NameOf(*check.reason);
  standing.superseded_detail = check.detail;
  return standing;
}

std::string DoubtSentence(const Standing& standing) {
  const bool is_dated = standing.superseded_at_us > 0;
  const std::string when = is_dated ? ", photographed at " + Rfc3339(standing.superseded_at_us) +
                                          ", does not show "
                                          "fit ground any more: "
                                    : ", which may be later or earlier, does not show fit ground: ";
  return "Doubted: the map of " + standing.JudgeId() + when + standing.superseded_detail + ".";
}

void ReportAll(MapCache& maps, const std::vector<SiteRow>& sites, const Standings& others) {
  for (const SiteRow& site : sites) Report(maps, site.id, site);
  for (const auto& [id, standing] : others) Report(maps, id, standing);
}

}  // namespace freelsd
