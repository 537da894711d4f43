#include <algorithm>
#include <set>
#include <stdexcept>

#include <nlohmann/json.hpp>

#include "api/import/import.h"
#include "api/import/poses/csv.h"
#include "api/import/poses/pose_columns.h"
#include "api/import/poses/pose_line.h"
#include "api/import/poses/poses.h"

namespace freelsd {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
// Largest number of lines reported in one error.
// A later line with this many known names is the header of another table.
constexpr size_t kMinHeaderColumns = 2;

std::vector<std::string> AssumptionsOf(const PoseColumns& header) {
  std::vector<std::string> warnings;
  const auto has = [&header](PoseField field) { return header.columns.count(field) != 0; };
  if (has(PoseField::kHeightAboveTakeOff) && !has(PoseField::kHeightAboveGround)) {
    warnings.emplace_back("height above take-off is used as height above ground");
  }
  const bool has_heading = has(PoseField::kYaw) || has(PoseField::kImageUpHeading);
  const bool has_tilt = has(PoseField::kGimbalPitch) || has(PoseField::kQuaternionW) ||
                        (has(PoseField::kRoll) && has(PoseField::kPitch));
  if (has_heading && !has_tilt) {
    warnings.emplace_back("only headings are given: roll and pitch are assumed level");
  }
  const auto wind = header.columns.find(PoseField::kWindFrom);
  if (wind != header.columns.end() && wind->second.name.find("from") == std::string::npos) {
    warnings.push_back("column \"" + wind->second.name + "\" is read as where the wind comes from");
  }
  // Altitudes are not converted: a flight has one datum of all its altitudes.
  if (const std::optional<std::string> datum = header.AltitudeDatum()) {
    warnings.push_back("column \"" + header.columns.at(PoseField::kAltitude).name +
                       "\" is of the datum " + *datum);
  }
  if (has(PoseField::kWindFrom) && has(PoseField::kWindTo)) {
    warnings.emplace_back(
        "where the wind comes from is used; where it blows to is used only if that is empty");
  }
  const auto time = header.columns.find(PoseField::kDateTime);
  if (time != header.columns.end() && time->second.name.find("utc") == std::string::npos) {
    warnings.emplace_back("times of column \"" + time->second.name + "\" are read as UTC");
  }
  return warnings;
}

bool IsRemark(std::string_view line) {
  const size_t first = line.find_first_not_of(" \t");
  return first != std::string_view::npos && line[first] == '#';
}

// Agisoft writes remarks before the header ("# Cameras (54)"), and # before the header itself.
std::vector<CsvLine> LinesFromHeader(std::string_view text) {
  int line_number = 1;
  std::string_view rest = text;
  while (IsRemark(rest.substr(0, rest.find('\n'))) &&
         NumKnownColumns(rest.substr(0, rest.find('\n'))) == 0) {
    rest.remove_prefix(std::min(rest.find('\n'), rest.size() - 1) + 1);
    ++line_number;
  }
  try {
    return ParseCsv(rest, line_number);
  } catch (const std::invalid_argument& error) {
    throw InvalidPose("/poses", error.what());
  }
}

bool HoldsValue(const std::string& cell) {
  return cell.find_first_not_of(" \t\r") != std::string::npos;
}

// The lines of poses: without remarks, without lines of empty cells, and without the table of
// something else (Agisoft's markers) that begins with another header.
std::vector<CsvLine> LinesOfPoses(const std::vector<CsvLine>& lines, PoseFile& file) {
  std::vector<CsvLine> poses;
  size_t num_remarks = 0;
  for (size_t i = 1; i < lines.size(); ++i) {
    const std::vector<std::string>& cells = lines[i].cells;
    if (std::none_of(cells.begin(), cells.end(), HoldsValue)) continue;
    if (!IsRemark(cells[0])) {
      poses.push_back(lines[i]);
    } else if (NumKnownColumns(cells) >= kMinHeaderColumns) {
      file.warnings.push_back("a second table begins at line " + std::to_string(lines[i].number) +
                              ": it is not read");
      break;
    } else {
      ++num_remarks;
    }
  }
  if (num_remarks > 0) {
    file.warnings.push_back(std::to_string(num_remarks) +
                            " lines that begin with # are read as comments");
  }
  return poses;
}

std::pair<std::string, FrameMeta> ReadCsvPose(const PoseColumns& header,
                                              const CsvLine& cells,
                                              size_t num_columns) {
  if (cells.cells.size() > num_columns) {
    throw InvalidPose(LinePointer(cells.number), "more cells than the header has columns");
  }
  const PoseLine line(header, cells);
  FrameMeta meta = ReadPoseLine(line);
  return {IdFromFileName(line.Text(PoseField::kImage).value()), std::move(meta)};
}

bool HoldsValues(const CsvLine& line, const std::vector<size_t>& columns) {
  return std::any_of(columns.begin(), columns.end(), [&line](size_t column) {
    return column < line.cells.size() && HoldsValue(line.cells[column]);
  });
}

PoseFile ParseCsvPoses(std::string_view text) {
  const std::vector<CsvLine> lines = LinesFromHeader(text);
  if (lines.empty()) throw InvalidPose("/poses", "the pose file is empty");
  const PoseColumns header = ReadHeader(lines[0]);
  PoseFile file;
  file.warnings = header.warnings;
  for (const std::string& warning : AssumptionsOf(header)) file.warnings.push_back(warning);
  std::optional<ApiError> first_error;
  std::vector<FieldError> errors;
  const std::vector<CsvLine> poses = LinesOfPoses(lines, file);
  if (std::any_of(poses.begin(), poses.end(), [&header](const CsvLine& line) {
        return HoldsValues(line, header.unnamed);
      })) {
    file.warnings.emplace_back("columns without a name hold values: ignored");
  }
  for (const CsvLine& line : poses) {
    if (errors.size() >= kLimits.answer.max_num_listed_errors) break;
    try {
      file.poses.push_back(ReadCsvPose(header, line, lines[0].cells.size()));
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
  if (text.size() > kLimits.poses.max_file_bytes) {
    ApiError error("PosesTooLarge", "the pose file is too large");
    error.limit = static_cast<double>(kLimits.poses.max_file_bytes);
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
