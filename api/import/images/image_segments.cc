#include "api/import/images/image_segments.h"

#include <string>

#include <zlib.h>

#include "api/limits.h"

namespace freelsd {
namespace {

using std::string_view_literals::operator""sv;

constexpr std::string_view kPngSignature = "\x89PNG\r\n\x1a\n"sv;
constexpr std::string_view kExifHeader = "Exif\0\0"sv;
constexpr std::string_view kXmpHeader = "http://ns.adobe.com/xap/1.0/\0"sv;
// Uncompressed international text: keyword, compression flag and method 0, no language.
constexpr std::string_view kPngXmpHeader = "XML:com.adobe.xmp\0\0\0\0\0"sv;
constexpr size_t kPngChunkOverhead = 12;  // length, type, CRC
// Programs that edit tags leave a second block. More of them are hostile.
constexpr size_t kMaxNumBlocks = 4;

void Add(std::string_view block, std::vector<std::string_view>& blocks) {
  if (blocks.size() < kMaxNumBlocks) blocks.push_back(block);
}

uint32_t Byte(std::string_view bytes, size_t at) { return static_cast<unsigned char>(bytes[at]); }

bool IsStandalone(uint8_t marker) { return marker == 0x01 || (marker >= 0xD0 && marker <= 0xD8); }

MetadataBlocks FindInJpeg(std::string_view bytes) {
  MetadataBlocks blocks;
  for (const JpegSegment& segment : JpegSegments(bytes)) {
    if (segment.marker != 0xE1) continue;
    const std::string_view payload = segment.payload;
    if (payload.starts_with(kExifHeader)) {
      Add(payload.substr(kExifHeader.size()), blocks.exif);
    } else if (payload.starts_with(kXmpHeader)) {
      Add(payload.substr(kXmpHeader.size()), blocks.xmp);
    }
  }
  return blocks;
}

MetadataBlocks FindInPng(std::string_view bytes) {
  MetadataBlocks blocks;
  PngChunks chunks(bytes);
  while (const std::optional<PngChunk> chunk = chunks.Next()) {
    const std::string_view payload = chunk->payload;
    if (chunk->type == "eXIf") {
      Add(payload, blocks.exif);
    } else if (chunk->type == "iTXt" && payload.substr(0, kPngXmpHeader.size()) == kPngXmpHeader) {
      Add(payload.substr(kPngXmpHeader.size()), blocks.xmp);
    }
  }
  return blocks;
}

}  // namespace

uint32_t BigEndian16(std::string_view bytes, size_t at) {
  return Byte(bytes, at) << 8 | Byte(bytes, at + 1);
}

uint32_t BigEndian32(std::string_view bytes, size_t at) {
  return BigEndian16(bytes, at) << 16 | BigEndian16(bytes, at + 2);
}

// As libjpeg, which skips bytes before the second marker.
bool IsJpeg(std::string_view bytes) { return bytes.size() > 3 && bytes.starts_with("\xFF\xD8"sv); }

bool IsPng(std::string_view bytes) {
  return bytes.substr(0, kPngSignature.size()) == kPngSignature;
}

bool IsStartOfFrame(uint8_t marker) {
  // C4, C8 and CC are tables and reserved.
  return marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
}

std::vector<JpegSegment> JpegSegments(std::string_view bytes) {
  std::vector<JpegSegment> segments;
  size_t at = 2;
  while (at + 4 <= bytes.size() && segments.size() < kLimits.tags.max_num_segments) {
    const auto marker = static_cast<uint8_t>(Byte(bytes, at + 1));
    if (Byte(bytes, at) != 0xFF || marker == 0xFF || marker == 0 || IsStandalone(marker)) {
      ++at;
      continue;
    }
    const size_t length = BigEndian16(bytes, at + 2);
    if (length < 2 || at + 2 + length > bytes.size()) break;
    segments.push_back({marker, bytes.substr(at + 4, length - 2)});
    if (marker == 0xDA) break;  // start of scan
    at += 2 + length;
  }
  return segments;
}

bool HasValidCrc(const PngChunk& chunk) {
  const auto* const checked = reinterpret_cast<const Bytef*>(chunk.type.data());
  const size_t num_checked = chunk.type.size() + chunk.payload.size();
  const uLong crc = crc32(0, checked, static_cast<uInt>(num_checked));
  // The checksum follows the payload; type and payload are views of the same bytes.
  return crc == BigEndian32({chunk.type.data(), num_checked + 4}, num_checked);
}

PngChunks::PngChunks(std::string_view bytes) : bytes_(bytes), at_(kPngSignature.size()) {}

std::optional<PngChunk> PngChunks::Next() {
  if (at_ + kPngChunkOverhead > bytes_.size()) return std::nullopt;
  const size_t length = BigEndian32(bytes_, at_);
  if (length > bytes_.size() - at_ - kPngChunkOverhead) return std::nullopt;
  const PngChunk chunk{bytes_.substr(at_ + 4, 4), bytes_.substr(at_ + 8, length)};
  at_ = chunk.type == "IEND" ? bytes_.size() : at_ + kPngChunkOverhead + length;
  return chunk;
}

MetadataBlocks FindMetadata(std::string_view bytes) {
  if (IsJpeg(bytes)) return FindInJpeg(bytes);
  if (IsPng(bytes)) return FindInPng(bytes);
  return {};
}

}  // namespace freelsd
