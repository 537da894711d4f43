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

void Report(MapCache& maps, const std::string& site_id, const Standing& standing) {
  if (standing.superseded_by) maps.DropPlans(site_id);
  if (standing.superseded_reason.empty()) return;
  spdlog::info("site {} is {} by {}: {}: {}",
               site_id,
               standing.superseded_by ? "superseded" : "doubted",
               standing.JudgeId(),
               standing.superseded_reason,
               standing.superseded_detail);
}

}  // namespace

Standing With(Standing standing,
              const PlanCheck& check,
              const MapRow& map,
              const std::string& shown_id) {
  if (check.verdict == PlanVerdict::kHolds) {
    standing.confirmed_at_us =
        std::max(standing.confirmed_at_us.value_or(map.seen_at_us), map.seen_at_us);
    const bool is_settled =
        standing.IsDoubted() && standing.superseded_at_us <= *standing.confirmed_at_us;
    return is_settled ? Undoubted(std::move(standing)) : standing;
  }
  const bool is_doubt = check.verdict == PlanVerdict::kDoubts;
  if (check.verdict != PlanVerdict::kFails && !is_doubt) return standing;
  if (is_doubt && (standing.superseded_by || map.seen_at_us <= standing.confirmed_at_us)) {
    return standing;
  }
  const std::string& present = standing.superseded_by_map.empty()
                                   ? standing.superseded_by.value_or("")
                                   : standing.superseded_by_map;
  const bool is_newest =
      (standing.IsDoubted() && !is_doubt) ||
      std::tie(standing.superseded_at_us, present) < std::tie(map.seen_at_us, map.id);
  if (!is_newest) return standing;
  standing.superseded_by = is_doubt ? std::nullopt : std::optional(shown_id);
  standing.superseded_by_map = map.is_of_flight || is_doubt ? map.id : "";
  standing.superseded_at_us = map.seen_at_us;
  standing.superseded_reason = NameOf(*check.reason);
  standing.superseded_detail = check.detail;
  return standing;
}

std::string DoubtSentence(const Standing& standing) {
  const std::string at =
      standing.superseded_at_us > 0 ? Rfc3339(standing.superseded_at_us) : "an unknown time";
  return "Doubted: the map of " + standing.JudgeId() + ", photographed at " + at +
         ", does not show fit ground any more: " + standing.superseded_detail + ".";
}

void ReportAll(MapCache& maps, const std::vector<SiteRow>& sites, const Standings& others) {
  for (const SiteRow& site : sites) Report(maps, site.id, site);
  for (const auto& [id, standing] : others) Report(maps, id, standing);
}

}  // namespace freelsd
