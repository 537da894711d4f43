#include "tests/evaluation/recorded/recorded_flight.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>

#include "api/api.h"
#include "api/import/images/images.h"
#include "api/import/import.h"
#include "api/import/poses/poses.h"

namespace freelsd {
namespace {

namespace fs = std::filesystem;

std::string ReadFile(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("cannot read " + path.string());
  std::ostringstream bytes;
  bytes << file.rdbuf();
  return bytes.str();
}

std::vector<fs::path> ImagesIn(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder / "images")) files.push_back(entry.path());
  if (files.empty()) throw std::runtime_error("no images in " + folder.string());
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

// What the file of poses says wins over the image's own tags.
RecordedFrames ReadRecordedFrames(const std::string& folder) {
  std::map<std::string, FrameMeta> poses;
  if (fs::exists(fs::path(folder) / "poses.csv")) {
    for (const auto& [name, meta] : ParsePoses(ReadFile(fs::path(folder) / "poses.csv")).poses) {
      poses[name] = meta;
    }
  }
  const ImageLimits limits;
  Rig rig;
  std::optional<LocalFrame> frame;
  std::vector<Frame> frames;
  for (const fs::path& path : ImagesIn(folder)) {
    const std::string name = path.filename().string();
    const std::string bytes = ReadFile(path);
    const ImageTags tags = ReadImageTags(bytes, SniffImage(bytes, limits));
    const auto pose = poses.find(name);
    const FrameMeta meta = pose == poses.end() ? tags.meta : Merged(pose->second, tags.meta);
    if (!frame.has_value()) {
      if (!tags.camera || !meta.position)
        throw std::runtime_error(name + ": no camera or position");
      rig.camera = *tags.camera;
      frame.emplace(*meta.position);
    }
    const auto index = static_cast<int64_t>(frames.size());
    frames.push_back(MakeFrame(name, DecodeImage(bytes, limits), meta, rig, *frame, index));
  }
  std::stable_sort(frames.begin(), frames.end(), [](const Frame& a, const Frame& b) {
    return a.timestamp_us < b.timestamp_us;
  });
  return {*frame, rig, std::move(frames)};
}

}  // namespace freelsd
