#include <algorithm>
#include <optional>
#include <string>

#include "api/import/images/image_segments.h"
#include "api/import/images/images.h"

namespace freelsd {
namespace {

constexpr size_t kPngHeaderEnd = 33;  // signature and the IHDR chunk
constexpr double kPixelsPerMegapixel = 1e6;

ApiError TooLarge(const std::string& detail, double limit, double observed) {
  ApiError error("ImageTooLarge", detail);
  error.limit = limit;
  error.observed = observed;
  return error;
}

ImageHeader ReadJpegHeader(std::string_view bytes) {
  const std::vector<JpegSegment> segments = JpegSegments(bytes);
  const auto frame = std::find_if(segments.begin(), segments.end(), [](const JpegSegment& each) {
    return IsStartOfFrame(each.marker);
  });
  if (frame == segments.end() || frame->payload.size() < 6) {
    throw ApiError("DamagedImage", "the JPEG has no frame header");
  }
  // Precision (1 byte), height, width, number of components.
  if (frame->payload[0] != 8) {
    throw ApiError("UnsupportedPixels", "only JPEG with 8 bits per channel is supported");
  }
  ImageHeader header;
  header.is_jpeg = true;
  header.height_px = static_cast<int>(BigEndian16(frame->payload, 1));
  header.width_px = static_cast<int>(BigEndian16(frame->payload, 3));
  return header;
}

ImageHeader ReadPngHeader(std::string_view bytes) {
  constexpr uint32_t kMaxPngSide = 0x7FFFFFFF;
  const std::optional<PngChunk> first = PngChunks(bytes.substr(0, kPngHeaderEnd)).Next();
  if (!first || first->type != "IHDR" || first->payload.size() != 13 || !HasValidCrc(*first) ||
      BigEndian32(first->payload, 0) > kMaxPngSide ||
      BigEndian32(first->payload, 4) > kMaxPngSide) {
    throw ApiError("DamagedImage", "the PNG has no valid header");
  }
  if (first->payload[8] == 16) {
    throw ApiError("UnsupportedPixels", "only PNG with up to 8 bits per channel is supported");
  }
  ImageHeader header;
  header.width_px = static_cast<int>(BigEndian32(first->payload, 0));
  header.height_px = static_cast<int>(BigEndian32(first->payload, 4));
  return header;
}

void CheckSize(const ImageHeader& header, const ImageLimits& limits) {
  const std::string size = std::to_string(header.width_px) + "x" + std::to_string(header.height_px);
  if (header.width_px <= 0 || header.height_px <= 0) {
    throw ApiError("DamagedImage", "the image's size is " + size);
  }
  const double pixels = static_cast<double>(header.width_px) * header.height_px;
  if (pixels > limits.max_megapixels * kPixelsPerMegapixel) {
    throw TooLarge(
        "the image has " + size + " pixels", limits.max_megapixels * kPixelsPerMegapixel, pixels);
  }
  const int side = std::max(header.width_px, header.height_px);
  if (side > limits.max_side_px) {
    throw TooLarge("the image has " + size + " pixels: too long a side", limits.max_side_px, side);
  }
}

}  // namespace

ImageHeader SniffImage(std::string_view bytes, const ImageLimits& limits) {
  if (!IsJpeg(bytes) && !IsPng(bytes)) {
    throw ApiError("UnsupportedImage", "the first bytes are of neither a JPEG nor a PNG");
  }
  if (bytes.size() > limits.max_bytes) {
    throw TooLarge("the image has " + std::to_string(bytes.size()) + " bytes",
                   static_cast<double>(limits.max_bytes),
                   static_cast<double>(bytes.size()));
  }
  const ImageHeader header = IsJpeg(bytes) ? ReadJpegHeader(bytes) : ReadPngHeader(bytes);
  CheckSize(header, limits);
  return header;
}

}  // namespace freelsd
