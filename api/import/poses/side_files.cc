#include "api/import/poses/side_files.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "api/import/number_text.h"
#include "api/import/poses/table.h"
#include "api/import/utf8.h"

namespace freelsd {
namespace {

// Bytes at the file's start from which the format is detected.
constexpr size_t kHeadBytes = 4096;
constexpr double kMaxNormError = 0.01;
// Numbers of a ground control point before the image's name.
constexpr size_t kNumGcpNumbers = 5;

// The beginning of a file, and its name, in lower case.
struct Head {
  std::string text;
  std::string name;
  bool is_yaml = false;
  bool is_json = false;

  explicit Head(const SideFile& file)
      : text(InLowerCase(ToUtf8(std::string_view(file.text).substr(0, kHeadBytes)))),
        name(InLowerCase(NameWithoutFolders(file.path))),
        is_yaml(name.ends_with(".yaml") || name.ends_with(".yml")),
        is_json(name.ends_with(".json")) {
    const size_t start = text.find_first_not_of(" \t\r\n");
    if (start != std::string::npos) text.erase(0, start);
  }
  bool Has(std::string_view word) const { return text.find(word) != std::string::npos; }
  bool Begins(std::string_view word) const { return text.rfind(word, 0) == 0; }
};

struct SideFormat {
  const char* name;
  // Reason for the detection.
  const char* why;
  bool (*is_it)(const Head& head);
  void (*read)(const SideFile& file, SideData& data);
};

void ReadPoseLines(const SideFile& file, SideData& data) {
  PoseFile read = ParsePoses(file.text, data.context);
  for (auto& pose : read.poses) data.file.poses.push_back(std::move(pose));
  for (auto& warning : read.warnings) {
    const bool is_of_line = warning.starts_with("line ");
    data.file.warnings.push_back(is_of_line ? ShownPath(file.path) + " " + warning : warning);
  }
}

void Ignore(const SideFile& file, SideData& data) {
  data.file.warnings.push_back(ShownPath(file.path) + ": the file is not needed, ignored");
}

void IgnoreGcps(const SideFile& file, SideData& data) {
  data.file.warnings.push_back(ShownPath(file.path) + ": ground control points are not used");
}

// In the first line that is not blank; a remark may stand before.
bool HasCoordinateSystem(const Head& head) {
  for (const TextLine& line : LinesOf(head.text, BlankLines::kKeep)) {
    if (!CoordinateSystemIn(line.text).empty()) return line.text[0] != '#';
    if (!line.text.empty() && line.text[0] != '#') return false;
  }
  return false;
}

// GPS week, and an angle with its letter: "[2237]", "47.35,Lat".
bool IsDjiMark(const Head& head) {
  return head.name.ends_with(".mrk") || (head.Has(",lat\t") && head.Has(",ellh\t"));
}

// x y z px py image; a line of geo.txt begins with the image.
bool IsGcpLine(const std::string& line) {
  const std::vector<std::string> words = WordsOf(line);
  return words.size() > kNumGcpNumbers &&
         std::all_of(words.begin(), words.begin() + kNumGcpNumbers, NumberFromText) &&
         !NumberFromText(words[kNumGcpNumbers]);
}

bool IsOdmGcp(const Head& head) {
  if (head.name == "gcp_list.txt") return true;
  const std::vector<TextLine> lines = LinesOf(head.text);
  return HasCoordinateSystem(head) && lines.size() > 1 && IsGcpLine(lines[1].text);
}

// The first matching format is used.
constexpr std::array<SideFormat, 16> kFormats{{
    {"colmap-cameras",
     "named cameras.txt, or begins with \"# Camera list\"",
     [](const Head& head) { return head.name == "cameras.txt" || head.Begins("# camera list"); },
     ReadColmapCameras},
    {"colmap-images",
     "named images.txt, or begins with \"# Image list\"",
     [](const Head& head) { return head.name == "images.txt" || head.Begins("# image list"); },
     ReadColmapImages},
    {"colmap-points",
     "named points3D.txt, or begins with \"# 3D point list\"",
     [](const Head& head) { return head.name == "points3d.txt" || head.Begins("# 3d point list"); },
     Ignore},
    {"colmap-rigs",
     "named rigs.txt or frames.txt",
     [](const Head& head) { return head.name == "rigs.txt" || head.name == "frames.txt"; },
     Ignore},
    {"opensfm",
     "a list in JSON with cameras",
     [](const Head& head) { return head.Begins("[") && head.Has("\"cameras\""); },
     ReadOpenSfm},
    {"opensfm-cameras",
     "an object in JSON of cameras",
     [](const Head& head) { return head.Begins("{") && head.Has("\"projection_type\""); },
     ReadOpenSfmCameras},
    {"opensfm-reference",
     "an object in JSON with latitude, longitude, altitude",
     [](const Head& head) {
       return head.Begins("{") && head.Has("\"latitude\"") && head.Has("\"longitude\"") &&
              !head.Has("\"image\"");
     },
     ReadReferenceLla},
    {"unknown-json",
     "its content is unknown",
     [](const Head& head) { return head.is_json && !head.Has("\"image\""); },
     Ignore},
    {"ndjson", "begins with {", [](const Head& head) { return head.Begins("{"); }, ReadPoseLines},
    {"kalibr-camchain",
     "has cam0 with a camera_model",
     [](const Head& head) { return head.Has("cam0:") && head.Has("camera_model:"); },
     ReadKalibr},
    {"ros-camera-info",
     "has camera_matrix and image_width",
     [](const Head& head) { return head.Has("camera_matrix:") && head.Has("image_width:"); },
     ReadCameraInfo},
    {"odm-gcp",
     "named gcp_list.txt, or rows x y z px py image below a coordinate system",
     IsOdmGcp,
     IgnoreGcps},
    {"dji-mrk", "named .MRK, or has \",Lat\" and \",Ellh\"", IsDjiMark, ReadDjiMarks},
    {"odm-geo", "its first line is a coordinate system", HasCoordinateSystem, ReadPoseLines},
    {"unknown-yaml",
     "its content is unknown",
     [](const Head& head) { return head.is_yaml; },
     Ignore},
    {"csv", "any other text is a table", [](const Head&) { return true; }, ReadPoseLines},
}};

void CheckSize(const SideFile& file) {
  if (file.text.size() <= kLimits.poses.max_file_bytes) return;
  ApiError error("PosesTooLarge", "the pose file is too large");
  error.limit = static_cast<double>(kLimits.poses.max_file_bytes);
  error.observed = static_cast<double>(file.text.size());
  throw error;
}

// The last format accepts every other file.
const SideFormat& FormatOf(const SideFile& file) {
  const Head head(file);
  return *std::find_if(
      kFormats.begin(), kFormats.end(), [&head](const auto& format) { return format.is_it(head); });
}

bool IsBlank(const SideFile& file) {
  return ToUtf8(std::string_view(file.text).substr(0, kHeadBytes)).find_first_not_of(" \t\r\n") ==
         std::string::npos;
}

void ReadOne(const SideFile& file, SideData& data) {
  CheckSize(file);
  if (IsBlank(file)) {
    data.file.warnings.push_back(ShownPath(file.path) + ": the file is empty, ignored");
  } else {
    FormatOf(file).read(file, data);
  }
}

// An empty file is only a warning if another file has content.
void RefuseNothing(const std::vector<SideFile>& files, const SideContext& context) {
  if (files.empty() || !context.image_tags.empty()) return;
  if (!std::all_of(files.begin(), files.end(), IsBlank)) return;
  throw InvalidSideFile(files[0], 0, "the file is empty");
}

void RefuseFramesTwice(const PoseFile& file) {
  std::set<std::string> ids;
  for (const auto& [id, meta] : file.poses) {
    if (ids.insert(id).second) continue;
    throw ApiError(
        "InvalidPoses", "two poses for the image " + id, {{"/poses", "two poses for " + id}});
  }
}

}  // namespace

ApiError InvalidSideFile(const SideFile& file, int line, const std::string& detail) {
  const std::string path = ShownPath(file.path);
  const std::string at = line > 0 ? " line " + std::to_string(line) : "";
  std::string pointer = "/poses/" + NameWithoutFolders(path);
  if (line > 0) pointer += "/" + std::to_string(line);
  return ApiError("InvalidPoses", path + at + ": " + detail, {{pointer, detail}});
}

std::string NameWithoutFolders(const std::string& path) {
  const size_t folder = path.find_last_of("/\\");
  return folder == std::string::npos ? path : path.substr(folder + 1);
}

std::vector<TextLine> LinesOf(std::string_view text, BlankLines blanks) {
  std::vector<TextLine> lines;
  int number = 0;
  while (!text.empty()) {
    ++number;
    const size_t end = std::min(text.find('\n'), text.size());
    std::string line(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.ends_with('\r')) line.pop_back();
    const size_t first = line.find_first_not_of(" \t");
    const bool is_blank = first == std::string::npos || line[first] == '#';
    if (is_blank && blanks == BlankLines::kSkip) continue;
    // A tab may stand behind an empty cell.
    lines.push_back(
        {number, first == std::string::npos ? "" : line.substr(line.find_first_not_of(' '))});
  }
  return lines;
}

std::vector<std::string> WordsOf(std::string_view line) {
  std::vector<std::string> words;
  while (true) {
    const size_t first = line.find_first_not_of(" \t\r");
    if (first == std::string_view::npos) return words;
    const size_t end = std::min(line.find_first_of(" \t\r", first), line.size());
    words.emplace_back(line.substr(first, end - first));
    line.remove_prefix(end);
  }
}

std::vector<double> NumbersOf(const std::vector<std::string>& words,
                              size_t first,
                              size_t last,
                              const SideFile& file,
                              int line) {
  std::vector<double> numbers;
  for (size_t i = first; i < last; ++i) {
    const std::optional<double> number = NumberFromText(words.at(i));
    if (!number) {
      throw InvalidSideFile(file, line, "\"" + ShownPath(words[i]) + "\" must be a finite number");
    }
    numbers.push_back(*number);
  }
  return numbers;
}

Eigen::Quaterniond QuaternionOf(
    double w, double x, double y, double z, const SideFile& file, int line) {
  const Eigen::Quaterniond quaternion(w, x, y, z);
  if (std::abs(quaternion.norm() - 1.0) > kMaxNormError) {
    throw InvalidSideFile(file, line, "the quaternion's length must be 1");
  }
  return quaternion.normalized();
}

std::string ImageIdOf(std::string_view path, const std::map<std::string, FrameMeta>& tags) {
  while (true) {
    std::string whole(path);
    std::replace_if(
        whole.begin(), whole.end(), [](char c) { return c == '/' || c == '\\'; }, '_');
    std::string id = IdFromFileName(whole);
    const size_t folder = path.find_first_of("/\\");
    if (folder == std::string_view::npos || tags.contains(id)) return id;
    path.remove_prefix(folder + 1);
  }
}

std::vector<PoseFile::Format> FormatsOf(const std::vector<SideFile>& files) {
  std::vector<PoseFile::Format> formats;
  for (const SideFile& file : files) {
    if (IsBlank(file)) continue;
    const SideFormat& format = FormatOf(file);
    formats.push_back({format.name, ShownPath(file.path), format.why});
  }
  return formats;
}

bool IsAnyText(const SideFile& file) {
  const Head head(file);
  if (!head.name.ends_with(".txt") || &FormatOf(file) != &kFormats.back()) return false;
  return !LooksLikeTable(ToUtf8(file.text));
}

PoseFile PosesFromFiles(const std::vector<SideFile>& files, const SideContext& context) {
  RefuseNothing(files, context);
  SideData data;
  data.context = context;
  data.tags.insert(context.image_tags.begin(), context.image_tags.end());
  data.file.formats = FormatsOf(files);
  for (const SideFile& file : files) ReadOne({file.path, ToUtf8(file.text)}, data);
  ChooseCamera(data);
  RefuseFramesTwice(data.file);
  Georeference(data);
  RefuseFramesTwice(data.file);
  for (const std::string& warning : SuspicionsOf(data.file, context)) {
    data.file.warnings.push_back(warning);
  }
  return std::move(data.file);
}

}  // namespace freelsd
