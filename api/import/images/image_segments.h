// The segments of JPEG files and the chunks of PNG files, without decoding. All views refer to the
// bytes that the caller passes.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace freelsd {

bool IsJpeg(std::string_view bytes);
bool IsPng(std::string_view bytes);

struct JpegSegment {
  uint8_t marker = 0;  // 0xE1 for APP1, ...
  std::string_view payload;
};
// Segments up to the start of the first scan. Bytes between segments are skipped, as libjpeg does.
// The list ends early if it reaches TagLimits::max_num_segments.
// It also ends early where the bytes are not valid JPEG.
std::vector<JpegSegment> JpegSegments(std::string_view bytes);
// True for SOF0 to SOF15, the segments that contain the image's size.
bool IsStartOfFrame(uint8_t marker);

struct PngChunk {
  std::string_view type;  // four letters
  std::string_view payload;
};
// True if the checksum after the chunk matches its bytes.
bool HasValidCrc(const PngChunk& chunk);
// Reads chunk by chunk, because a list of many empty chunks would be far larger than the file.
class PngChunks {
 public:
  // `bytes` is a whole PNG file with its signature.
  explicit PngChunks(std::string_view bytes);
  // The next chunk. Nothing after IEND, or if the bytes end within a chunk.
  std::optional<PngChunk> Next();

 private:
  std::string_view bytes_;
  size_t at_;
};

// EXIF (from the TIFF header on) and XMP (XML text) of a JPEG or PNG, in the order of the file.
struct MetadataBlocks {
  std::vector<std::string_view> exif;
  std::vector<std::string_view> xmp;
};
MetadataBlocks FindMetadata(std::string_view bytes);

// Read big-endian unsigned integers. The caller must check the size.
uint32_t BigEndian16(std::string_view bytes, size_t at);
uint32_t BigEndian32(std::string_view bytes, size_t at);

}  // namespace freelsd
