#include "api/export/png.h"

#include <algorithm>
#include <csetjmp>
#include <stdexcept>

#include <opencv2/imgproc.hpp>
#include <png.h>
#include <zlib.h>

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

// The space is reserved beforehand: an exception must not pass through libpng.
void Append(png_structp png, png_bytep data, png_size_t size) {
  static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<const char*>(data), size);
}

void Flush(png_structp) {}

// Frees what libpng has allocated.
struct PngWriter {
  PngWriter() = default;
  PngWriter(const PngWriter&) = delete;
  PngWriter& operator=(const PngWriter&) = delete;
  ~PngWriter() { png_destroy_write_struct(&png, &info); }
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png ? png_create_info_struct(png) : nullptr;
};

bool IsOpaque(const cv::Mat4b& picture) {
  for (int row = 0; row < picture.rows; ++row) {
    const cv::Vec4b* pixels = picture[row];
    if (!std::all_of(pixels, pixels + picture.cols, [](const cv::Vec4b& pixel) {
          return pixel[3] == 255;
        })) {
      return false;
    }
  }
  return true;
}

// False if libpng has failed; it then jumps here.
bool WriteRows(const PngWriter& writer, const cv::Mat& picture, std::string* bytes) {
  if (setjmp(png_jmpbuf(writer.png)) != 0) return false;
  png_set_write_fn(writer.png, bytes, Append, Flush);
  png_set_IHDR(writer.png,
               writer.info,
               static_cast<png_uint_32>(picture.cols),
               static_cast<png_uint_32>(picture.rows),
               8,
               picture.channels() == 4 ? PNG_COLOR_TYPE_RGB_ALPHA : PNG_COLOR_TYPE_RGB,
               PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  png_set_filter(writer.png, PNG_FILTER_TYPE_BASE, PNG_FILTER_UP);
  png_set_compression_level(writer.png, Z_BEST_SPEED);
  png_set_compression_strategy(writer.png, Z_DEFAULT_STRATEGY);
  png_write_info(writer.png, writer.info);
  png_set_bgr(writer.png);
  for (int row = 0; row < picture.rows; ++row) png_write_row(writer.png, picture.ptr(row));
  png_write_end(writer.png, writer.info);
  return true;
}

}  // namespace

std::string EncodePngQuickly(const cv::Mat4b& picture) {
  if (picture.empty()) throw std::invalid_argument("PNG: an image of 8 bit BGRA is needed");
  cv::Mat written = picture;
  if (IsOpaque(picture)) cv::cvtColor(picture, written, cv::COLOR_BGRA2BGR);
  const PngWriter writer;
  std::string bytes;
  // More than zlib needs if nothing can be compressed, and the chunks.
  bytes.reserve(written.total() * written.elemSize() * 11 / 10 + written.rows + 65536);
  if (!writer.info || !WriteRows(writer, written, &bytes)) {
    throw std::runtime_error("PNG: an image cannot be written");
  }
  return bytes;
}

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
