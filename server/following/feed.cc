#include "server/following/feed.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include <nlohmann/json.hpp>

#include "api/api.h"
#include "engine/geometry/geometry.h"
#include "server/following/told_change.h"
#include "server/recall/recall.h"

namespace freelsd {
namespace {

// Beyond what a plan, its circles and their surroundings need.
constexpr double kSurroundingsM = 10000.0;
// A page ends with the change that exceeds it.
constexpr size_t kMaxPageBytes = size_t{4} << 20;

std::optional<int64_t> NumberOf(std::string_view text) {
  int64_t number = 0;
  const char* const end = text.data() + text.size();
  const auto [stopped_at, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc() || stopped_at != end || number < 0) return std::nullopt;
  return number;
}

std::string TextOf(const FeedPlace& place) {
  return place.feed + "-" + std::to_string(place.number) + "-" + std::to_string(place.begun_at);
}

bool IsWithin(double longitude_deg, double latitude_deg, const BoundingBox& box) {
  if (latitude_deg < box.south_deg || latitude_deg > box.north_deg) return false;
  if (box.west_deg <= box.east_deg) {
    return longitude_deg >= box.west_deg && longitude_deg <= box.east_deg;
  }
  return longitude_deg >= box.west_deg || longitude_deg <= box.east_deg;
}

bool Meet(const BoundingBox& a, const BoundingBox& box) {
  if (a.south_deg > box.north_deg || a.north_deg < box.south_deg) return false;
  const auto meets = [&a](double west_deg, double east_deg) {
    return a.west_deg <= east_deg && a.east_deg >= west_deg;
  };
  if (box.west_deg <= box.east_deg) return meets(box.west_deg, box.east_deg);
  return meets(box.west_deg, 180.0) || meets(-180.0, box.east_deg);
}

// Maps do not move.
bool HasLeft(const ToldChange& told, const ChangeArea& area) {
  if (told.site) {
    return !IsWithin(told.site->longitude_deg, told.site->latitude_deg, area.sites);
  }
  return told.obstacle && !Meet(told.obstacle->box, area.surroundings);
}

std::optional<std::string> WhyAnew(const ChangeStore& changes, const FeedPlace& since) {
  if (since.feed.empty()) return std::nullopt;
  if (since.feed != changes.FeedId() || since.number > changes.LastNumber()) return "other_feed";
  const int64_t forgotten = changes.ForgottenThrough();
  if (since.number < forgotten && since.begun_at < forgotten) return "removals_forgotten";
  return std::nullopt;
}

}  // namespace

FeedPlace ParseFeedPlace(const std::string& text) {
  if (text == "0") return {};
  const size_t last = text.rfind('-');
  const size_t first = last == std::string::npos || last == 0 ? last : text.rfind('-', last - 1);
  if (first != std::string::npos && first > 0 && first < last) {
    const auto number = NumberOf(std::string_view(text).substr(first + 1, last - first - 1));
    const auto begun_at = NumberOf(std::string_view(text).substr(last + 1));
    if (number && begun_at) return {text.substr(0, first), *number, *begun_at};
  }
  const std::string detail = "since: must be 0 or `next` of an earlier answer";
  throw ApiError("InvalidQuery", detail, {{"since", detail}});
}

ChangeArea ChangeAreaOf(const BoundingBox& area) {
  const double dlat_deg = kSurroundingsM / kMetresPerDegree;
  const double far_deg =
      std::min(89.0, std::max(std::abs(area.south_deg), std::abs(area.north_deg)) + dlat_deg);
  const double dlon_deg = dlat_deg / std::cos(RadFromDeg(far_deg));
  const double width_deg =
      area.east_deg - area.west_deg + (area.west_deg > area.east_deg ? 360 : 0);
  BoundingBox wide{-180.0,
                   std::max(-90.0, area.south_deg - dlat_deg),
                   180.0,
                   std::min(90.0, area.north_deg + dlat_deg)};
  if (width_deg + 2.0 * dlon_deg < 360.0) {
    wide.west_deg = std::remainder(area.west_deg - dlon_deg, 360.0);
    wide.east_deg = std::remainder(area.east_deg + dlon_deg, 360.0);
  }
  return {area, wide};
}

nlohmann::json FeedPage(const Storage& storage, const FeedRequest& request) {
  const FeedPlace& since = request.since;
  const std::string feed = storage.changes.FeedId();
  nlohmann::json answer{{"feed", feed},
                        {"changes", nlohmann::json::array()},
                        {"removals_kept_days", kRemovalsKeptDays}};
  if (const auto why = WhyAnew(storage.changes, since)) {
    answer.update({{"begin_anew", *why}, {"next", "0"}, {"has_more", true}});
    return answer;
  }
  const bool is_first = since.feed.empty();
  const int64_t begun_at = is_first ? storage.changes.LastNumber() : since.begun_at;
  std::optional<ChangeArea> area;
  if (request.area) area = ChangeAreaOf(*request.area);
  const ChangePage page = storage.changes.List(since.number, request.limit, area);
  int64_t last_number = since.number;
  bool has_more = page.has_more;
  size_t num_bytes = 0;
  for (const ChangeRow& change : page.changes) {
    if (num_bytes > kMaxPageBytes) {
      has_more = true;
      break;
    }
    const bool is_wanted =
        request.subjects.empty() || request.subjects.contains(change.key.subject);
    std::optional<ToldChange> told;
    if (is_wanted) told = ReadTold(storage, change);
    if (is_wanted && !told) {
      // It changes just now: the next page has it, and until then the feed is not at its end.
      has_more = true;
      break;
    }
    last_number = change.number;
    if (!told || (is_first && told->IsRemoval())) continue;
    told->has_left = area && !told->IsRemoval() && HasLeft(*told, *area);
    if (is_first && told->has_left) continue;
    answer["changes"].push_back(ToldJson(*told, feed));
    num_bytes += answer["changes"].back().dump().size();
  }
  if (!has_more) last_number = page.last_number;
  answer["next"] = TextOf({feed, last_number, begun_at});
  answer["has_more"] = has_more;
  return answer;
}

}  // namespace freelsd
