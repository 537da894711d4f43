#include "api/export/png.h"

#include <stdexcept>

#include <png.h>

namespace freelsd {
namespace {

std::string Encode(const cv::Mat& image, uint32_t format, const void* palette) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = static_cast<png_uint_32>(image.cols);
  png.height = static_cast<png_uint_32>(image.rows);
  png.format = format;
  png.flags = PNG_IMAGE_FLAG_FAST;
  if (palette) png.colormap_entries = 256;
  const auto stride = static_cast<png_int_32>(image.step[0]);
  std::string bytes(PNG_IMAGE_PNG_SIZE_MAX(png), '\0');
  png_alloc_size_t size = bytes.size();
  if (png_image_write_to_memory(&png, bytes.data(), &size, 0, image.data, stride, palette) == 0) {
    throw std::runtime_error(std::string("PNG: ") + png.message);
  }
  bytes.resize(size);
  return bytes;
}

}  // namespace

std::string EncodePng(const cv::Mat& image) {
  if (image.empty() || (image.type() != CV_8UC3 && image.type() != CV_8UC4)) {
    throw std::invalid_argument("PNG: an image of 8 bit BGR or BGRA is needed");
  }
  return Encode(image, image.channels() == 4 ? PNG_FORMAT_BGRA : PNG_FORMAT_BGR, nullptr);
}

std::string EncodePalettePng(const cv::Mat1b& indices, const std::array<cv::Vec4b, 256>& palette) {
  if (indices.empty()) throw std::invalid_argument("PNG: an image of 8 bit indices is needed");
  return Encode(indices, PNG_FORMAT_BGRA_COLORMAP, palette.data());
}

}  // namespace freelsd
