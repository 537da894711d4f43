#include <set>
#include <stdexcept>

#include <nlohmann/json.hpp>

#include "api/import/csv.h"
#include "api/import/import.h"
#include "api/import/pose_columns.h"
#include "api/import/pose_line.h"

namespace freelsd {
namespace {

constexpr size_t kMaxPoseFileBytes = 64u << 20;
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
// Lines told of at once.
constexpr size_t kMaxNumListedErrors = 20;

std::vector<std::string> AssumptionsOf(const PoseColumns& header) {
  std::vector<std::string> warnings;
  const auto has = [&header](PoseField field) { return header.columns.count(field) != 0; };
  if (has(PoseField::kHeightAboveTakeOff) && !has(PoseField::kHeightAboveGround)) {
    warnings.emplace_back("height above take-off is taken as height above ground");
  }
  const bool has_heading = has(PoseField::kYaw) || has(PoseField::kImageUpHeading);
  const bool has_tilt =
      has(PoseField::kGimbalPitch) || (has(PoseField::kRoll) && has(PoseField::kPitch));
  if (has_heading && !has_tilt) {
    warnings.emplace_back("only headings are given: roll and pitch are taken as level");
  }
  const auto wind = header.columns.find(PoseField::kWindFrom);
  if (wind != header.columns.end() && wind->second.name.find("from") == std::string::npos) {
    warnings.push_back("column \"" + wind->second.name + "\" is taken as where wind comes from");
  }
  if (has(PoseField::kWindFrom) && has(PoseField::kWindTo)) {
    warnings.emplace_back(
        "where wind comes from is taken, where it blows to only if that is empty");
  }
  const auto time = header.columns.find(PoseField::kDateTime);
  if (time != header.columns.end() && time->second.name.find("utc") == std::string::npos) {
    warnings.emplace_back("times of column \"" + time->second.name + "\" are taken as UTC");
  }
  return warnings;
}

PoseFile ParseCsvPoses(std::string_view text) {
  std::vector<CsvLine> lines;
  try {
    lines = ParseCsv(text);
  } catch (const std::invalid_argument& error) {
    throw InvalidPose("/poses", error.what());
  }
  if (lines.empty()) throw InvalidPose("/poses", "the pose file is empty");
  const PoseColumns header = ReadHeader(lines[0].cells);
  PoseFile file;
  file.warnings = header.warnings;
  for (const std::string& warning : AssumptionsOf(header)) file.warnings.push_back(warning);
  std::optional<ApiError> first_error;
  std::vector<FieldError> errors;
  for (size_t i = 1; i < lines.size() && errors.size() < kMaxNumListedErrors; ++i) {
    try {
      if (lines[i].cells.size() > lines[0].cells.size()) {
        throw InvalidPose(LinePointer(lines[i].number), "more cells than the header has columns");
      }
      const PoseLine line(header, lines[i]);
      FrameMeta meta = ReadPoseLine(line);
      file.poses.emplace_back(IdFromFileName(line.Text(PoseField::kImage).value()),
                              std::move(meta));
    } catch (const ApiError& error) {
      if (!first_error) first_error = error;
      errors.insert(errors.end(), error.errors().begin(), error.errors().end());
    }
  }
  if (first_error) throw ApiError(first_error->code(), first_error->what(), errors);
  return file;
}

std::pair<std::string, FrameMeta> ParseNdjsonLine(const std::string& text, int number) {
  const std::string pointer = LinePointer(number);
  try {
    nlohmann::json object = ParseJson(text);
    const bool has_image = object.is_object() && object.contains("image");
    if (!has_image || !object["image"].is_string() || object["image"].get<std::string>().empty()) {
      throw ApiError("InvalidPoses", "image: is needed", {{"/image", "image: is needed"}});
    }
    const std::string id = IdFromFileName(object["image"].get<std::string>());
    object.erase("image");
    return {id, ParseFrameMeta(object.dump())};
  } catch (const ApiError& error) {
    const std::string at = error.errors().empty() ? "" : error.errors()[0].pointer;
    const std::string detail = "line " + std::to_string(number) + ": " + error.what();
    throw ApiError(error.code(), detail, {{pointer + at, detail}});
  }
}

PoseFile ParseNdjsonPoses(std::string_view text) {
  PoseFile file;
  int number = 0;
  while (!text.empty()) {
    ++number;
    const size_t end = std::min(text.find('\n'), text.size());
    const std::string line(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    file.poses.push_back(ParseNdjsonLine(line, number));
  }
  return file;
}

void RefuseDuplicates(const PoseFile& file) {
  std::set<std::string> ids;
  for (const auto& [id, meta] : file.poses) {
    if (!ids.insert(id).second) throw InvalidPose("/poses", "two poses for the image " + id);
  }
}

}  // namespace

PoseFile ParsePoses(std::string_view text) {
  if (text.size() > kMaxPoseFileBytes) {
    ApiError error("PosesTooLarge", "the pose file is too large");
    error.limit = static_cast<double>(kMaxPoseFileBytes);
    error.observed = static_cast<double>(text.size());
    throw error;
  }
  if (text.substr(0, kByteOrderMark.size()) == kByteOrderMark) {
    text.remove_prefix(kByteOrderMark.size());
  }
  const size_t first = text.find_first_not_of(" \t\r\n");
  const bool is_ndjson = first != std::string_view::npos && text[first] == '{';
  PoseFile file = is_ndjson ? ParseNdjsonPoses(text) : ParseCsvPoses(text);
  RefuseDuplicates(file);
  return file;
}

}  // namespace freelsd
