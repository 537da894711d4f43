// What comes as bytes: images, archives, models, stored maps.
#include <cstdlib>
#include <stdexcept>

#include <sys/mman.h>
#include <unistd.h>

#include "api/import/images/images.h"
#include "api/stored/map/map.h"
#include "api/stored/stored.h"
#include "tests/fuzz/targets.h"

namespace freelsd {
namespace {

// Small: what is decoded here is decoded many times.
ImageLimits SmallLimits() {
  ImageLimits limits;
  limits.max_megapixels = 0.25;
  return limits;
}

// A file without a disk.
class MemoryFile {
 public:
  explicit MemoryFile(std::string_view bytes) : descriptor_(::memfd_create("fuzz", MFD_CLOEXEC)) {
    if (::write(descriptor_, bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size())) {
      std::abort();
    }
  }
  ~MemoryFile() { ::close(descriptor_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  std::string path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }

 private:
  int descriptor_;
};

}  // namespace

void FuzzImageHeader(std::string_view bytes) {
  const ImageLimits limits;
  const ImageHeader header = SniffImage(bytes, limits);
  const bool is_bounded = header.width_px > 0 && header.height_px > 0 &&
                          header.width_px <= limits.max_side_px &&
                          header.height_px <= limits.max_side_px;
  if (!is_bounded) std::abort();
}

void FuzzImageTags(std::string_view bytes) {
  const ImageHeader header{true, 564, 360};
  const ImageTags tags = ReadImageTags(bytes, header);
  if (tags.camera) tags.camera->Check();
  FrameMetaJson(tags.meta);
}

void FuzzImageDecoding(std::string_view bytes) {
  const ImageHeader header = SniffImage(bytes, SmallLimits());
  const cv::Mat image = DecodeImage(bytes, SmallLimits());
  if (image.cols != header.width_px || image.rows != header.height_px) std::abort();
}

void FuzzZip(std::string_view bytes) {
  const MemoryFile file(bytes);
  ZipLimits limits;
  limits.max_entries = 50;
  limits.max_entry_bytes = limits.max_total_bytes = 1 << 20;
  uint64_t total = 0;
  ReadZip(file.path(), limits, [&](const std::string& path, std::string&& content) {
    total += content.size();
    if (path.empty() || total > limits.max_total_bytes) std::abort();
  });
}

void FuzzModel(std::string_view bytes) {
  const Classifier model = Classifier::Parse(std::string(bytes));
  // What was read can be written, and read again.
  Classifier::Parse(model.Serialize());
}

void FuzzPhotoTile(std::string_view bytes) { DeserializePhotoTile(std::string(bytes)); }

void FuzzMapTile(std::string_view bytes) {
  const Grid grid = GridOf(MapTileIndex{}, 1.0);
  const MapRasters tile = DeserializeTile(std::string(bytes), grid, TileLayers::kWithCues);
  const std::string again = SerializeTile(tile);
  if (!again.empty()) DeserializeTile(again, grid, TileLayers::kWithCues);
}

}  // namespace freelsd
