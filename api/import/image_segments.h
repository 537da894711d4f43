// The skeleton of JPEG and PNG files: what lies where, without decoding anything. Views into the
// bytes that were given.
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
// Segments up to the start of the first scan, at most max_count; ends early where the bytes do not
// go on as a JPEG.
std::vector<JpegSegment> JpegSegments(std::string_view bytes);
// SOF0 to SOF15: the segment that holds the size.
bool IsStartOfFrame(uint8_t marker);

struct PngChunk {
  std::string_view type;  // four letters
  std::string_view payload;
};
// Whether the checksum behind it is that of its bytes.
bool HasValidCrc(const PngChunk& chunk);
// Chunk by chunk: a file of nothing but empty ones would make a list many times its size.
class PngChunks {
 public:
  // The bytes of a PNG, signature included.
  explicit PngChunks(std::string_view bytes);
  // Nothing behind IEND, and where the bytes end within a chunk.
  std::optional<PngChunk> Next();

 private:
  std::string_view bytes_;
  size_t at_;
};

// EXIF (starting with the TIFF header) and XMP (XML text) of a JPEG or PNG; empty where absent.
struct MetadataBlocks {
  std::string_view exif;
  std::string_view xmp;
};
MetadataBlocks FindMetadata(std::string_view bytes);

// Big-endian unsigned integers; the caller checks the size.
uint32_t BigEndian16(std::string_view bytes, size_t at);
uint32_t BigEndian32(std::string_view bytes, size_t at);

}  // namespace freelsd
