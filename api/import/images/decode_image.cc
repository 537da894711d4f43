#include <memory>
#include <optional>
#include <string>

#include <opencv2/imgproc.hpp>
#include <png.h>
#include <turbojpeg.h>

#include "api/import/images/image_segments.h"
#include "api/import/images/images.h"

namespace freelsd {
namespace {

struct CloseHandle {
  void operator()(void* handle) const { tjDestroy(handle); }
};

ApiError Damaged(const std::string& detail) { return ApiError("DamagedImage", detail); }

cv::Mat DecodeJpeg(std::string_view bytes, const ImageHeader& header) {
  // A new handle per call: after an error a handle refuses good photographs.
  const std::unique_ptr<void, CloseHandle> handle(tjInitDecompress());
  if (!handle) throw std::runtime_error("turbojpeg: no decoder");
  const auto* const data = reinterpret_cast<const unsigned char*>(bytes.data());
  const auto size = static_cast<unsigned long>(bytes.size());
  int width = 0, height = 0, subsampling = 0, colorspace = 0;
  if (tjDecompressHeader3(handle.get(), data, size, &width, &height, &subsampling, &colorspace) !=
      0) {
    throw Damaged(std::string("JPEG: ") + tjGetErrorStr2(handle.get()));
  }
  if (width != header.width_px || height != header.height_px) {
    throw Damaged("JPEG: two frame headers disagree");
  }
  if (colorspace == TJCS_CMYK || colorspace == TJCS_YCCK) {
    throw ApiError("UnsupportedPixels", "a JPEG with four colour channels is not supported");
  }
  cv::Mat image(height, width, CV_8UC3);
  // A warning means damage: the decoder fills the missing rows of a truncated photograph.
  const int flags = TJFLAG_STOPONWARNING | TJFLAG_LIMITSCANS;
  if (tjDecompress2(handle.get(), data, size, image.data, width, 0, height, TJPF_BGR, flags) != 0) {
    throw Damaged(std::string("JPEG: ") + tjGetErrorStr2(handle.get()));
  }
  return image;
}

// Checks the PNG and removes all chunks without pixels. Texts and profiles are deflated too, so a
// small chunk may unpack to any size.
std::string PixelChunks(std::string_view bytes) {
  constexpr size_t kSignatureBytes = 8;
  std::string kept(bytes.substr(0, kSignatureBytes));
  kept.reserve(bytes.size());
  PngChunks chunks(bytes);
  std::string_view last_type;
  bool has_transparency = false;
  while (const std::optional<PngChunk> chunk = chunks.Next()) {
    if (!HasValidCrc(*chunk)) throw Damaged("PNG: a chunk does not match its checksum");
    last_type = chunk->type;
    // libpng prints a line for each unexpected chunk, so a second one is left out.
    const bool is_transparency = last_type == "tRNS" && !has_transparency;
    has_transparency |= is_transparency;
    const bool is_needed = (last_type[0] & 0x20) == 0 || is_transparency;
    // The length precedes the chunk and the checksum follows it; all are views of the same bytes.
    if (is_needed) kept.append(last_type.data() - 4, chunk->payload.size() + 12);
  }
  if (last_type != "IEND") throw Damaged("PNG: the end is missing");
  return kept;
}

struct FreeImage {
  png_image image{};
  FreeImage() { image.version = PNG_IMAGE_VERSION; }
  ~FreeImage() { png_image_free(&image); }
  FreeImage(const FreeImage&) = delete;
  FreeImage& operator=(const FreeImage&) = delete;
};

cv::Mat DecodePng(std::string_view bytes, const ImageHeader& header) {
  const std::string pixels = PixelChunks(bytes);
  FreeImage reader;
  png_image& png = reader.image;
  if (png_image_begin_read_from_memory(&png, pixels.data(), pixels.size()) == 0) {
    throw Damaged(std::string("PNG: ") + png.message);
  }
  if (static_cast<int>(png.width) != header.width_px ||
      static_cast<int>(png.height) != header.height_px) {
    throw Damaged("PNG: two headers disagree");
  }
  if ((png.format & PNG_FORMAT_FLAG_LINEAR) != 0) {
    throw ApiError("UnsupportedPixels", "only PNG with up to 8 bits per channel is supported");
  }
  // Keeps the stored alpha; otherwise libpng would blend the image with a background.
  const bool has_alpha = (png.format & PNG_FORMAT_FLAG_ALPHA) != 0;
  png.format = has_alpha ? PNG_FORMAT_BGRA : PNG_FORMAT_BGR;
  cv::Mat image(header.height_px, header.width_px, has_alpha ? CV_8UC4 : CV_8UC3);
  const bool is_read = png_image_finish_read(&png, nullptr, image.data, 0, nullptr) != 0;
  // A warning means damage, as for JPEG.
  if (!is_read || png.warning_or_error != 0) throw Damaged(std::string("PNG: ") + png.message);
  if (has_alpha) cv::cvtColor(image, image, cv::COLOR_BGRA2BGR);
  return image;
}

}  // namespace

cv::Mat DecodeImage(std::string_view bytes, const ImageLimits& limits) {
  const ImageHeader header = SniffImage(bytes, limits);
  return header.is_jpeg ? DecodeJpeg(bytes, header) : DecodePng(bytes, header);
}

}  // namespace freelsd
