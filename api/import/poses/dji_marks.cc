// DJI's MRK file: the moments of an RTK flight's exposures, one line each, by the number of the
// photograph: number, GPS seconds, [week], offsets, latitude,Lat longitude,Lon height,Ellh,
// standard deviations, quality.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <functional>

#include "api/import/number_text.h"
#include "api/import/poses/side_files.h"

namespace freelsd {
namespace {

constexpr int64_t kGpsEpochS = 315964800;
constexpr int64_t kWeekS = 7 * 86400;
// Since 2017.
constexpr int64_t kLeapSeconds = 18;
constexpr size_t kMaxNumberDigits = 6;

struct Mark {
  int number = 0;
  FrameMeta meta;
};

// "47.35,Lat" -> 47.35 for the label "lat".
std::optional<double> Labelled(const std::vector<std::string>& words, const std::string& label) {
  for (const std::string& word : words) {
    const size_t comma = word.find(',');
    if (comma == std::string::npos) continue;
    if (InLowerCase(word.substr(comma + 1)) != label) continue;
    return NumberFromText(word.substr(0, comma));
  }
  return std::nullopt;
}

std::optional<int64_t> TimeOf(const std::vector<std::string>& words) {
  const std::string& week_text = words.at(2);
  if (week_text.size() < 3 || week_text.front() != '[' || week_text.back() != ']') return {};
  const auto week = NumberFromText(week_text.substr(1, week_text.size() - 2));
  const auto seconds = NumberFromText(words[1]);
  constexpr double kMaxWeek = 1e4;
  if (!week || !seconds || !(*week >= 0 && *week <= kMaxWeek)) return {};
  if (!(*seconds >= 0 && *seconds <= static_cast<double>(kWeekS))) return {};
  return (kGpsEpochS + static_cast<int64_t>(*week) * kWeekS - kLeapSeconds) * 1000000 +
         std::llround(*seconds * 1e6);
}

std::optional<Mark> MarkOf(const std::string& line) {
  const std::vector<std::string> words = WordsOf(line);
  if (words.size() < 6) return std::nullopt;
  const auto number = NumberFromText(words[0]);
  const auto latitude = Labelled(words, "lat"), longitude = Labelled(words, "lon"),
             height_m = Labelled(words, "ellh");
  constexpr double kMaxNumber = 1e6, kMaxHeightM = 20000.0;
  const bool is_usable = number && *number >= 0 && *number <= kMaxNumber && latitude && longitude &&
                         height_m && std::abs(*latitude) <= 90.0 && std::abs(*longitude) <= 180.0 &&
                         std::abs(*height_m) <= kMaxHeightM;
  // Without a fix DJI writes zeros.
  if (!is_usable || (*latitude == 0.0 && *longitude == 0.0)) return std::nullopt;
  Mark mark{static_cast<int>(*number), {}};
  mark.meta.position = GeoPoint{*latitude, *longitude, *height_m};
  mark.meta.altitude_datum = "ellipsoid";
  mark.meta.timestamp_us = TimeOf(words);
  return mark;
}

// The last short number of a photograph's name: 12 of "DJI_20240601102634_0012_W.JPG".
std::optional<int> NumberIn(const std::string& image_id) {
  std::optional<int> number;
  std::string digits;
  for (const char c : image_id.substr(0, image_id.rfind('.')) + " ") {
    if (std::isdigit(static_cast<unsigned char>(c)) != 0) {
      digits += c;
      continue;
    }
    if (!digits.empty() && digits.size() <= kMaxNumberDigits) number = std::stoi(digits);
    digits.clear();
  }
  return number;
}

}  // namespace

void ReadDjiMarks(const SideFile& file, SideData& data) {
  std::vector<std::string> ids;
  for (const auto& [image_id, tags] : data.context.image_tags) ids.push_back(image_id);
  // "100_0001_Timestamp.MRK" belongs to "100_0001_0012.JPG".
  const std::string name = NameWithoutFolders(file.path);
  const std::string flight = name.substr(0, name.find("Timestamp"));
  const auto is_of_flight = [&flight](const std::string& id) { return id.starts_with(flight); };
  if (std::any_of(ids.begin(), ids.end(), is_of_flight))
    std::erase_if(ids, std::not_fn(is_of_flight));
  size_t num_marks = 0, num_unread = 0, num_without_image = 0;
  for (const TextLine& line : LinesOf(file.text)) {
    const std::optional<Mark> mark = MarkOf(line.text);
    num_unread += !mark;
    num_marks += mark.has_value();
    bool has_image = false;
    for (const std::string& id : ids) {
      if (!mark || NumberIn(id) != mark->number) continue;
      data.file.poses.emplace_back(id, mark->meta);
      has_image = true;
    }
    num_without_image += mark && !has_image;
  }
  const std::string path = ShownPath(file.path);
  if (num_marks == 0)
    throw InvalidSideFile(file, 0, "there is no exposure with latitude and height");
  if (num_without_image == num_marks) {
    throw InvalidSideFile(
        file, 0, "its exposures have the numbers of no photograph in the request");
  }
  const auto tell = [&](size_t num, const char* what) {
    if (num > 0) data.file.warnings.push_back(path + ": " + std::to_string(num) + what);
  };
  tell(num_unread, " lines cannot be read: left out");
  tell(num_without_image, " exposures have no photograph in the request");
}

}  // namespace freelsd
