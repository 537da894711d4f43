// Pages of lists: the query parameters limit and cursor, and the member next of an answer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <tuple>

#include <nlohmann/json_fwd.hpp>

#include "api/api.h"
#include "server/http/http.h"

namespace freelsd {

// Parameter limit. Absent: kLimits.answer.max_num_listed. Throws ApiError InvalidQuery or
// InvalidValue.
size_t ParseLimit(const Call& call);

// Parameter cursor of a list whose items are numbered. Nothing if it is absent. Throws ApiError
// InvalidQuery.
std::optional<int64_t> ParseNumberCursor(const Call& call);

// Answers {"<name>": [<items>], "next": …}. `items`: JSON texts, separated by commas. `next`:
// number of the page's last item; nothing if no more items follow.
void AnswerPage(const std::string& name,
                const std::string& items,
                std::optional<int64_t> next,
                httplib::Response& response);

// A cursor of a list that is ordered by rank.
std::optional<RankKey> ParseRankCursor(const Call& call);
std::string CursorOf(const RankKey& key);

// Order of a list by what a new look gains: minus the gain, then the id.
using NewLookKey = std::tuple<double, std::string>;
// The last site of a page, and the time at which the ages of all pages are taken.
struct NewLookCursor {
  int64_t now_us = 0;
  NewLookKey last;
};
std::optional<NewLookCursor> ParseNewLookCursor(const Call& call);
std::string CursorOf(const NewLookCursor& cursor);

// Answers GeoJSON, cut at the antimeridian.
void AnswerGeoJson(nlohmann::json geojson, httplib::Response& response);
// Answers a FeatureCollection of points. `features`: JSON, separated by commas. `next`: cursor if
// others follow.
void AnswerFeatures(const std::string& features,
                    const std::optional<std::string>& next,
                    httplib::Response& response);

}  // namespace freelsd
