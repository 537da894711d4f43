#include "server/handlers/paging.h"

#include <array>
#include <charconv>
#include <utility>

#include <nlohmann/json.hpp>

#include "api/export/geojson/geojson.h"

namespace freelsd {
namespace {

constexpr char kGeoJson[] = "application/geo+json";
// Separates the parts of a cursor. It occurs in no id and in no number, and needs no escape in
// URLs.
constexpr char kSeparator = '~';

[[noreturn]] void RefuseCursor() {
  throw ApiError("InvalidQuery",
                 "cursor: must be the value of next of an earlier page",
                 {{"cursor", "must be the value of next of an earlier page"}});
}

// Parses the whole text.
template <typename Number>
Number ParseWhole(const std::string& text) {
  Number number{};
  const char* const end = text.data() + text.size();
  const auto [stopped_at, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc() || stopped_at != end) RefuseCursor();
  return number;
}

// Parts of the parameter cursor, which is three texts. The last may contain a separator.
std::optional<std::array<std::string, 3>> ParseThreeParts(const Call& call) {
  const std::optional<std::string> text = call.Query("cursor");
  if (!text) return std::nullopt;
  const size_t first = text->find(kSeparator);
  if (first == std::string::npos) RefuseCursor();
  const size_t second = text->find(kSeparator, first + 1);
  if (second == std::string::npos) RefuseCursor();
  return std::array<std::string, 3>{text->substr(0, first),
                                    text->substr(first + 1, second - first - 1),
                                    text->substr(second + 1)};
}

// The shortest text that parses to the same number.
std::string ShortestText(double number) {
  std::array<char, 40> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), number).ptr};
}

}  // namespace

size_t ParseLimit(const Call& call) {
  constexpr auto kMax = static_cast<int64_t>(kLimits.answer.max_num_listed);
  const int64_t limit = call.QueryInteger("limit").value_or(kMax);
  if (limit < 1 || limit > kMax) {
    const std::string rule =
        "must be an integer from 1 to " + std::to_string(kLimits.answer.max_num_listed);
    throw ApiError("InvalidValue", "limit: " + rule, {{"limit", rule}});
  }
  return static_cast<size_t>(limit);
}

std::optional<int64_t> ParseNumberCursor(const Call& call) {
  const std::optional<std::string> text = call.Query("cursor");
  if (!text) return std::nullopt;
  return ParseWhole<int64_t>(*text);
}

void AnswerPage(const std::string& name,
                const std::string& items,
                std::optional<int64_t> next,
                httplib::Response& response) {
  std::string body = "{\"" + name + "\":[" + items + "]";
  if (next) body += ",\"next\":\"" + std::to_string(*next) + "\"";
  response.set_content(body + "}", "application/json");
}

std::optional<RankKey> ParseRankCursor(const Call& call) {
  const auto parts = ParseThreeParts(call);
  if (!parts) return std::nullopt;
  const auto& [verdict_order, minus_score, id] = *parts;
  return RankKey{ParseWhole<int>(verdict_order), ParseWhole<double>(minus_score), id};
}

std::string CursorOf(const RankKey& key) {
  const auto& [verdict_order, minus_score, id] = key;
  return std::to_string(verdict_order) + kSeparator + ShortestText(minus_score) + kSeparator + id;
}

std::optional<NewLookCursor> ParseNewLookCursor(const Call& call) {
  const auto parts = ParseThreeParts(call);
  if (!parts) return std::nullopt;
  const auto& [now_us, minus_gain, id] = *parts;
  NewLookCursor cursor{ParseWhole<int64_t>(now_us), {ParseWhole<double>(minus_gain), id}};
  // A later time is not that of an earlier page.
  if (cursor.now_us < 0 || cursor.now_us > NowUs()) RefuseCursor();
  return cursor;
}

std::string CursorOf(const NewLookCursor& cursor) {
  const auto& [minus_gain, id] = cursor.last;
  return std::to_string(cursor.now_us) + kSeparator + ShortestText(minus_gain) + kSeparator + id;
}

void AnswerGeoJson(nlohmann::json geojson, httplib::Response& response) {
  response.set_content(CutAtAntimeridian(std::move(geojson)).dump(), kGeoJson);
}

void AnswerFeatures(const std::string& features,
                    const std::optional<std::string>& next,
                    httplib::Response& response) {
  std::string body = R"({"type":"FeatureCollection","features":[)" + features + "]";
  if (next) body += R"(,"next":)" + nlohmann::json(*next).dump();
  response.set_content(body + "}", kGeoJson);
}

}  // namespace freelsd
