// One page of the feed of changes, as followers get it.
#pragma once

#include <optional>
#include <set>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "storage/storage.h"

namespace freelsd {

// Removals are told for this time. Who follows on after a longer pause begins anew.
constexpr int64_t kRemovalsKeptDays = 30;

// Place in a feed: "<feed>-<number>-<last number when the follower began>". "0" is the beginning.
struct FeedPlace {
  std::string feed;
  int64_t number = 0;
  int64_t begun_at = 0;
};
// Throws ApiError InvalidQuery.
FeedPlace ParseFeedPlace(const std::string& text);

// The area, with the sites that touch down in it, and with the maps and obstacles within 10 km.
ChangeArea ChangeAreaOf(const BoundingBox& area);

struct FeedRequest {
  FeedPlace since;
  std::optional<BoundingBox> area;
  size_t limit = 200;
  // Empty: all.
  std::set<ChangeSubject> subjects = {};
};
// {feed, changes, next, has_more, begin_anew?}. With begin_anew, a reason, there are no changes:
// the follower goes on from the beginning and removes what it is not told again.
nlohmann::json FeedPage(const Storage& storage, const FeedRequest& request);

}  // namespace freelsd
