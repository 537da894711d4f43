#include <algorithm>
#include <array>
#include <cstdio>
#include <optional>
#include <string>

// jerror.h has codes that depend on jpeglib.h.
// clang-format off
#include <jpeglib.h>
#include <jerror.h>
// clang-format on
#include <opencv2/imgproc.hpp>
#include <png.h>

#include "api/import/images/image_segments.h"
#include "api/import/images/images.h"

namespace freelsd {
namespace {

ApiError Damaged(const std::string& detail) { return ApiError("DamagedImage", detail); }

// A warning of libjpeg that changes no pixel: of the ends of segments and of headers.
bool IsHarmless(int code) {
  return code == JWRN_JPEG_EOF || code == JWRN_EXTRANEOUS_DATA || code == JWRN_NOT_SEQUENTIAL ||
         code == JWRN_ADOBE_XFORM || code == JWRN_JFIF_MAJOR || code == JWRN_BOGUS_ICC;
}

// One JPEG. libjpeg reports errors by callbacks that must not return; exceptions pass through it,
// because it has tables for unwinding, and the destructor frees its memory.
class JpegReader {
 public:
  explicit JpegReader(std::string_view bytes) {
    decoder_.err = jpeg_std_error(&errors_);
    decoder_.client_data = this;
    errors_.error_exit = [](j_common_ptr decoder) { Of(decoder).Fail(); };
    errors_.emit_message = [](j_common_ptr decoder, int level) {
      if (level < 0) Of(decoder).Warn();
    };
    jpeg_create_decompress(&decoder_);
    progress_.progress_monitor = [](j_common_ptr decoder) { Of(decoder).LimitScans(); };
    decoder_.progress = &progress_;
    jpeg_mem_src(&decoder_,
                 reinterpret_cast<const unsigned char*>(bytes.data()),
                 static_cast<unsigned long>(bytes.size()));
  }
  ~JpegReader() { jpeg_destroy_decompress(&decoder_); }
  JpegReader(const JpegReader&) = delete;
  JpegReader& operator=(const JpegReader&) = delete;

  DecodedImage Read(const ImageHeader& header) {
    jpeg_read_header(&decoder_, TRUE);
    if (static_cast<int>(decoder_.image_width) != header.width_px ||
        static_cast<int>(decoder_.image_height) != header.height_px) {
      throw Damaged("JPEG: two frame headers disagree");
    }
    if (decoder_.jpeg_color_space == JCS_CMYK || decoder_.jpeg_color_space == JCS_YCCK) {
      throw ApiError("UnsupportedPixels", "a JPEG with four colour channels is not supported");
    }
    decoder_.out_color_space = JCS_EXT_BGR;
    jpeg_start_decompress(&decoder_);
    DecodedImage image{cv::Mat(header.height_px, header.width_px, CV_8UC3), {}};
    while (decoder_.output_scanline < decoder_.output_height) {
      JSAMPROW row = image.pixels.ptr(static_cast<int>(decoder_.output_scanline));
      jpeg_read_scanlines(&decoder_, &row, 1);
    }
    image.warnings = warnings_;
    return image;
  }

 private:
  static JpegReader& Of(j_common_ptr decoder) {
    return *static_cast<JpegReader*>(decoder->client_data);
  }

  std::string Message() {
    std::array<char, JMSG_LENGTH_MAX> text{};
    errors_.format_message(reinterpret_cast<j_common_ptr>(&decoder_), text.data());
    return std::string("JPEG: ") + text.data();
  }

  [[noreturn]] void Fail() { throw Damaged(Message()); }

  // The decoder fills what is missing with grey.
  void Warn() {
    if (errors_.msg_code == JWRN_HIT_MARKER) {
      const auto num_rows = decoder_.image_height;
      const auto num_missing = num_rows - std::min(num_rows, decoder_.output_scanline);
      throw Damaged("JPEG: " + std::to_string(num_missing) + " of " + std::to_string(num_rows) +
                    " rows are missing or damaged: the file is cut");
    }
    if (!IsHarmless(errors_.msg_code)) throw Damaged(Message());
    if (!warnings_.empty()) return;
    warnings_.push_back(Message() + ": the photograph is whole all the same");
  }

  void LimitScans() {
    constexpr int kMaxNumScans = 500;
    if (decoder_.input_scan_number > kMaxNumScans) throw Damaged("JPEG: too many scans");
  }

  jpeg_decompress_struct decoder_{};
  jpeg_error_mgr errors_{};
  jpeg_progress_mgr progress_{};
  std::vector<std::string> warnings_;
};

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

DecodedImage DecodeAndTell(std::string_view bytes, const ImageLimits& limits) {
  const ImageHeader header = SniffImage(bytes, limits);
  if (!header.is_jpeg) return {DecodePng(bytes, header), {}};
  // The rest of a file that was cut may be zeros, which would decode as pixels. The last scan may
  // itself end with a zero, after FF.
  const size_t num_zeros = bytes.size() - 1 - bytes.find_last_not_of('\0');
  constexpr size_t kMostOfAScan = 2;
  bytes.remove_suffix(num_zeros - std::min(num_zeros, kMostOfAScan));
  return JpegReader(bytes).Read(header);
}

cv::Mat DecodeImage(std::string_view bytes, const ImageLimits& limits) {
  return DecodeAndTell(bytes, limits).pixels;
}

}  // namespace freelsd
