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
  bool has_valid_crc = false;
};
// Chunks up to IEND or to where the bytes end within one.
std::vector<PngChunk> PngChunks(std::string_view bytes);

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
