// The parts of images that the mosaic shows, decoded when needed.
#pragma once

#include <cstdint>
#include <list>
#include <map>
#include <mutex>
#include <vector>

#include <opencv2/core.hpp>

#include "engine/flight/flight.h"

namespace freelsd {

// Which part of a view's image is needed, and at which size.
struct ImagePart {
  std::string frame_id;
  // Pixels of the full-size image.
  cv::Rect part;
  // Size of the kept part divided by its full size, at most 1.
  double scale = 1.0;
};

struct LoadedPart {
  // Empty if the image is unavailable.
  cv::Mat3b image;
  // Pixels of the full-size image that `image` shows.
  cv::Rect part;
};

// Forgets what was used longest ago. Keeps at least one image. Thread-safe: threads wait for each
// other, also while one loads.
class ImageCache {
 public:
  ImageCache(const ImageSource& source, std::vector<ImagePart> parts, double max_mb);

  LoadedPart Fetch(size_t number);

 private:
  LoadedPart Load(const ImagePart& wanted) const;

  struct Entry {
    size_t number = 0;
    LoadedPart loaded;
  };

  const ImageSource& source_;
  const std::vector<ImagePart> parts_;
  const double max_bytes_;
  // Guards bytes_ and entries_.
  std::mutex mutex_;
  double bytes_ = 0.0;
  // The front was used last.
  std::list<Entry> entries_;
};

}  // namespace freelsd
