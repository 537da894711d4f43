#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>

#include <nlohmann/json.hpp>

#include "api/import/import.h"
#include "api/import/number_text.h"
#include "api/import/poses/pose_line.h"
#include "api/import/poses/poses.h"
#include "api/import/poses/side_files.h"
#include "api/import/poses/table.h"
#include "api/import/utf8.h"

namespace freelsd {
namespace {

constexpr std::string_view kPoses = "/poses/";

// An error of a table as people read it: "2" and "\"lat\" is needed and empty".
struct LineError {
  explicit LineError(const FieldError& field) {
    const std::string at = field.pointer.substr(std::min(field.pointer.size(), kPoses.size()));
    const size_t slash = std::min(at.find('/'), at.size());
    line = at.substr(0, slash);
    reason = (slash < at.size() ? "\"" + at.substr(slash + 1) + "\" " : "") + field.detail;
  }
  std::string line;
  std::string reason;
};

// Values and lines that are left out, told once for each reason.
class LeftOut {
 public:
  void Add(const ApiError& error, const std::string& what) {
    errors_.insert(errors_.end(), error.errors().begin(), error.errors().end());
    const LineError first(error.errors().at(0));
    Reason& told = reasons_[first.reason + what];
    if (told.num++ == 0) told.first_line = first.line;
  }
  const std::vector<FieldError>& errors() const { return errors_; }
  void AddTo(std::vector<std::string>& warnings) const {
    for (const auto& [reason, told] : reasons_) {
      if (warnings.size() >= kMaxNumWarnings) return;
      const std::string more =
          told.num > 1 ? " (and " + std::to_string(told.num - 1) + " more)" : "";
      warnings.push_back("line " + told.first_line + more + ": " + reason);
    }
  }

 private:
  struct Reason {
    size_t num = 0;
    std::string first_line;
  };
  static constexpr size_t kMaxNumWarnings = 200;
  std::map<std::string, Reason> reasons_;
  std::vector<FieldError> errors_;
};

bool IsSamePlace(const FrameMeta& a, const FrameMeta& b) {
  constexpr double kSameDeg = 1e-7, kSameM = 0.1;
  return std::abs(a.position->latitude_deg - b.position->latitude_deg) < kSameDeg &&
         std::abs(a.position->longitude_deg - b.position->longitude_deg) < kSameDeg &&
         std::abs(a.position->altitude_m - b.position->altitude_m) < kSameM;
}

// Of two lines for one image the first is used if they agree, and none if not.
void RemoveRepeated(PoseFile& file) {
  std::map<std::string, std::pair<size_t, bool>> known;
  std::vector<std::pair<std::string, FrameMeta>> kept;
  for (auto& [id, meta] : file.poses) {
    const auto [found, is_new] = known.try_emplace(id, kept.size(), true);
    if (is_new) {
      kept.emplace_back(id, std::move(meta));
    } else {
      found->second.second =
          found->second.second && IsSamePlace(kept[found->second.first].second, meta);
      file.warnings.push_back("two poses for the image " + id +
                              (found->second.second ? ": the first is used" : ": none is used"));
    }
  }
  std::erase_if(kept, [&known](const auto& pose) { return !known.at(pose.first).second; });
  file.poses = std::move(kept);
}

std::pair<std::string, FrameMeta> ReadPose(const TableFrame& frame,
                                           const TableLine& line,
                                           size_t num_columns,
                                           const LeaveOut& leave_out) {
  const auto is_empty = [](const std::string& cell) { return cell.empty(); };
  const size_t num_cells = std::min(line.cells.size(), num_columns);
  if (!std::all_of(line.cells.begin() + static_cast<long>(num_cells), line.cells.end(), is_empty)) {
    throw InvalidPose(LinePointer(line.number), "more cells than the header has columns");
  }
  const PoseLine cells(frame, line);
  FrameMeta meta = ReadPoseLine(cells, leave_out);
  return {ImageIdOf(cells.Text(PoseField::kImage).value(), frame.tags), std::move(meta)};
}

PoseFile ParseTable(std::string_view text, const SideContext& context) {
  const Table table = ReadTable(text);
  if (!table.header && table.lines.empty()) throw InvalidPose("/poses", "the pose file is empty");
  const TableFrame frame = FrameOf(table, context);
  PoseFile file;
  file.warnings = frame.header.warnings;
  file.warnings.insert(file.warnings.end(), table.warnings.begin(), table.warnings.end());
  const auto& unnamed = frame.header.unnamed;
  const bool has_nameless =
      std::any_of(table.lines.begin(), table.lines.end(), [&](const auto& line) {
        return std::any_of(unnamed.begin(), unnamed.end(), [&line](size_t column) {
          return column < line.cells.size() && !line.cells[column].empty();
        });
      });
  if (has_nameless) file.warnings.emplace_back("columns without a name hold values: ignored");
  const size_t num_columns =
      table.header ? table.header->cells.size() : std::numeric_limits<size_t>::max();
  LeftOut left_out;
  for (const TableLine& line : table.lines) {
    try {
      file.poses.push_back(ReadPose(frame, line, num_columns, [&](const ApiError& error) {
        left_out.Add(error, ": this value is left out");
      }));
    } catch (const ApiError& error) {
      left_out.Add(error, ": the line is left out");
    }
  }
  left_out.AddTo(file.warnings);
  RemoveRepeated(file);
  if (!file.poses.empty() || table.lines.empty()) return file;
  std::vector<FieldError> errors = left_out.errors();
  if (errors.empty()) errors = {{"/poses", file.warnings.back()}};
  errors.resize(std::min(errors.size(), kLimits.answer.max_num_listed_errors));
  const LineError first(errors[0]);
  throw ApiError("InvalidPoses",
                 first.line.empty() ? first.reason : "line " + first.line + ": " + first.reason,
                 errors);
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

PoseFile ParsePoses(std::string_view bytes, const SideContext& context) {
  if (bytes.size() > kLimits.poses.max_file_bytes) {
    ApiError error("PosesTooLarge", "the pose file is too large");
    error.limit = static_cast<double>(kLimits.poses.max_file_bytes);
    error.observed = static_cast<double>(bytes.size());
    throw error;
  }
  std::string text = ToUtf8(bytes);
  // Some spreadsheets end lines with it alone.
  if (text.find('\n') == std::string::npos) std::replace(text.begin(), text.end(), '\r', '\n');
  const size_t first = text.find_first_not_of(" \t\r\n");
  const bool is_ndjson = first != std::string::npos && text[first] == '{';
  if (!is_ndjson) return ParseTable(text, context);
  PoseFile file = ParseNdjsonPoses(text);
  RefuseDuplicates(file);
  return file;
}

}  // namespace freelsd
