// Stored sites in the order in which a new look at their ground gains most.
#include "server/handlers/new_look.h"

#include <algorithm>
#include <sstream>

#include <nlohmann/json.hpp>

#include "api/api.h"
#include "server/handlers/bounding_box.h"
#include "server/handlers/lookups.h"
#include "server/handlers/paging.h"
#include "server/recall/recall.h"

namespace freelsd {
namespace {

// An unverified site counts half: a part of its circle, or its wind, is unknown.
constexpr double kUnverifiedShare = 0.5;

struct Gain {
  NewLookKey key;
  double value = 0.0;
  std::optional<double> age_s;
  std::string verdict;
  const SiteRow* row = nullptr;
};

double ShareOf(const std::string& verdict) {
  if (verdict == "landable") return 1.0;
  return verdict == "unverified" ? kUnverifiedShare : 0.0;
}

Gain GainOf(const SiteRow& row, int64_t now_us) {
  const nlohmann::json feature = nlohmann::json::parse(row.feature_json);
  const nlohmann::json& properties = feature.at("properties");
  const auto score = properties.find("score");
  const bool has_score = score != properties.end() && score->is_number();
  Gain gain;
  gain.verdict = row.IsDoubted() ? "unverified" : properties.value("verdict", "rejected");
  gain.value = ShareOf(gain.verdict) * (has_score ? score->get<double>() : 0.0);
  gain.age_s = GroundAgeS(row.LastSeenUs(), now_us);
  gain.key = {-gain.value * (1.0 - ScoreLeft(gain.age_s)), row.id};
  gain.row = &row;
  return gain;
}

// Sites of today's standing, best gain first.
std::vector<Gain> Gains(const std::vector<SiteRow>& sites, int64_t now_us) {
  std::vector<Gain> gains;
  for (const SiteRow& site : sites) {
    if (site.superseded_by) continue;
    Gain gain = GainOf(site, now_us);
    if (ShareOf(gain.verdict) > 0.0) gains.push_back(std::move(gain));
  }
  std::sort(gains.begin(), gains.end(), [](const Gain& a, const Gain& b) { return a.key < b.key; });
  return gains;
}

std::string SentenceOf(const Gain& gain, double lost) {
  std::ostringstream text;
  text.setf(std::ios::fixed);
  text.precision(2);
  text << "The ground of this " << gain.verdict << " site was photographed "
       << (gain.age_s ? AgeText(*gain.age_s) + " ago" : "at an unknown time")
       << ": a new look regains " << lost << " of its value of " << gain.value << ".";
  return text.str();
}

nlohmann::json FeatureWith(const Gain& gain, int64_t now_us) {
  nlohmann::json feature = FeatureOf(*gain.row, now_us);
  const double lost = -std::get<0>(gain.key);
  feature["properties"]["new_look"] = {
      {"value", gain.value}, {"gain", lost}, {"sentence", SentenceOf(gain, lost)}};
  feature["properties"]["new_look"]["age_s"] = feature["properties"]["age_s"];
  return feature;
}

}  // namespace

void GetSitesByNewLook(Service& service, const Call& call, httplib::Response& response) {
  if (call.Query("include")) {
    const std::string detail = "include: order=new_look leaves out what is superseded";
    throw ApiError("InvalidQuery", detail, {{"include", detail}});
  }
  const std::optional<BoundingBox> box = ParseBoundingBox(call);
  const size_t limit = ParseLimit(call);
  const std::optional<NewLookCursor> after = ParseNewLookCursor(call);
  // All pages have the ages of the first one: else a gain could change between two pages.
  const int64_t now_us = after ? after->now_us : NowUs();
  const std::vector<SiteRow> sites = service.storage.sites.List(std::nullopt, box);
  const std::vector<Gain> gains = Gains(sites, now_us);
  const auto is_up_to = [](const NewLookKey& key, const Gain& gain) { return key < gain.key; };
  const auto first =
      after ? std::upper_bound(gains.begin(), gains.end(), after->last, is_up_to) : gains.begin();
  const auto end = first + static_cast<std::ptrdiff_t>(
                               std::min(limit, static_cast<size_t>(gains.end() - first)));
  std::string features;
  for (auto gain = first; gain != end; ++gain) {
    nlohmann::json feature = FeatureWith(*gain, now_us);
    feature["properties"]["rank"] = gain - gains.begin() + 1;
    features += (gain == first ? "" : ",") + feature.dump();
  }
  std::optional<std::string> next;
  if (end != gains.end()) next = CursorOf(NewLookCursor{now_us, (end - 1)->key});
  AnswerFeatures(features, next, response);
}

}  // namespace freelsd
