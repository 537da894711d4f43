#include "engine/mosaic/image_cache.h"

#include <algorithm>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "engine/mosaic/view_layer.h"

namespace freelsd {
namespace {

double BytesOf(const LoadedPart& loaded) {
  return static_cast<double>(loaded.image.total() * loaded.image.elemSize());
}

}  // namespace

ImageCache::ImageCache(const ImageSource& source, std::vector<ImagePart> parts, double max_mb)
    : source_(source), parts_(std::move(parts)), max_bytes_(max_mb * 1e6) {}

LoadedPart ImageCache::Load(const ImagePart& wanted) const {
  const cv::Mat image = source_(wanted.frame_id);
  LoadedPart loaded;
  loaded.part = wanted.part & cv::Rect(cv::Point(), image.size());
  if (loaded.part.area() == 0) return loaded;
  const cv::Mat3b color = AsColor(image(loaded.part));
  if (wanted.scale >= 1.0) {
    loaded.image = color.clone();
  } else {
    cv::resize(color, loaded.image, {}, wanted.scale, wanted.scale, cv::INTER_AREA);
  }
  return loaded;
}

LoadedPart ImageCache::Fetch(size_t number) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto found = std::find_if(
      entries_.begin(), entries_.end(), [&](const Entry& entry) { return entry.number == number; });
  if (found != entries_.end()) {
    entries_.splice(entries_.begin(), entries_, found);
    return entries_.front().loaded;
  }
  entries_.push_front({number, Load(parts_[number])});
  bytes_ += BytesOf(entries_.front().loaded);
  while (bytes_ > max_bytes_ && entries_.size() > 1) {
    bytes_ -= BytesOf(entries_.back().loaded);
    entries_.pop_back();
  }
  return entries_.front().loaded;
}

}  // namespace freelsd
