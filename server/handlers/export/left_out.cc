#include "server/handlers/export/left_out.h"

#include <algorithm>

#include <nlohmann/json.hpp>

namespace freelsd {
namespace {

void Add(const std::string& reason, const std::string& id, std::vector<LeftOutGroup>& groups) {
  const auto same = std::find_if(groups.begin(), groups.end(), [&reason](const auto& group) {
    return group.reason == reason;
  });
  if (same == groups.end()) {
    groups.push_back({reason, {id}});
  } else {
    same->ids.push_back(id);
  }
}

std::string ReasonOf(const FrameRow& frame) {
  if (frame.state == FrameState::kQueued) return "not processed yet";
  if (frame.state == FrameState::kRejected) {
    return "rejected: " + (frame.reason.empty() ? "reason unknown" : frame.reason);
  }
  if (!frame.reason.empty()) return "on no map: " + frame.reason;
  return "on no map: they add little to their neighbours, or too little in them matches the "
         "neighbours";
}

std::string ReasonOf(const nlohmann::json& region) {
  const auto count = [&region](const char* name) { return region.value(name, int64_t{0}); };
  if (region.contains("grade") && region["grade"].is_number() && region["grade"] > 0.0) {
    return "not evaluated, or the landing there is that of another site";
  }
  return count("num_grass_observations") > 0 ? "seen too seldom" : "never seen as grass";
}

}  // namespace

std::vector<LeftOutGroup> PhotographsLeftOut(const std::vector<FrameRow>& frames,
                                             const std::set<std::string>& used) {
  std::vector<LeftOutGroup> groups;
  for (const FrameRow& frame : frames) {
    if (!used.contains(frame.id)) Add(ReasonOf(frame), frame.id, groups);
  }
  return groups;
}

std::vector<LeftOutGroup> RegionsLeftOut(const std::vector<RegionRow>& regions,
                                         const std::set<int64_t>& with_site) {
  std::vector<LeftOutGroup> groups;
  for (const RegionRow& region : regions) {
    if (with_site.contains(region.id)) continue;
    const nlohmann::json feature = nlohmann::json::parse(region.feature_json);
    Add(ReasonOf(feature.at("properties")), "r" + std::to_string(region.id), groups);
  }
  return groups;
}

}  // namespace freelsd
