#include "api/export/jpeg.h"

#include <memory>
#include <stdexcept>

#include <turbojpeg.h>

namespace freelsd {
namespace {

constexpr int kJpegQuality = 85;

// On white.
cv::Mat3b Flattened(const cv::Mat4b& picture) {
  constexpr int kWhite = 255;
  cv::Mat3b flat(picture.size());
  for (int row = 0; row < flat.rows; ++row) {
    for (int col = 0; col < flat.cols; ++col) {
      const cv::Vec4b& pixel = picture(row, col);
      for (int i = 0; i < 3; ++i) {
        const int sum = pixel[i] * pixel[3] + kWhite * (kWhite - pixel[3]);
        flat(row, col)[i] = static_cast<uint8_t>((sum + kWhite / 2) / kWhite);
      }
    }
  }
  return flat;
}

}  // namespace

std::string EncodeJpeg(const cv::Mat4b& picture) {
  const cv::Mat3b image = Flattened(picture);
  struct CloseHandle {
    void operator()(void* handle) const { tjDestroy(handle); }
  };
  const std::unique_ptr<void, CloseHandle> handle(tjInitCompress());
  if (!handle) throw std::runtime_error("JPEG: cannot be started");
  std::string bytes(tjBufSize(image.cols, image.rows, TJSAMP_420), '\0');
  auto* data = reinterpret_cast<unsigned char*>(bytes.data());
  unsigned long size = bytes.size();
  if (tjCompress2(handle.get(),
                  image.data,
                  image.cols,
                  static_cast<int>(image.step[0]),
                  image.rows,
                  TJPF_BGR,
                  &data,
                  &size,
                  TJSAMP_420,
                  kJpegQuality,
                  TJFLAG_NOREALLOC) != 0) {
    throw std::runtime_error(std::string("JPEG: ") + tjGetErrorStr2(handle.get()));
  }
  bytes.resize(size);
  return bytes;
}

}  // namespace freelsd
