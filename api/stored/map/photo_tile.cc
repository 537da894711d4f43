// The stored form of a tile of the picture: a JPEG, which any program can show. Where pixels are
// transparent, these follow behind its end:
//   "FLPA", size of the deflated alpha (u32), CRC-32 of the alpha (u32), then the alpha deflated,
//   a byte per pixel, row by row.
#include <cstring>
#include <memory>
#include <stdexcept>

#include <turbojpeg.h>
#include <zlib.h>

#include "api/stored/map/map.h"

namespace freelsd {
namespace {

constexpr char kPictureMagic[4] = {'F', 'L', 'P', 'A'};
constexpr int kQuality = 88;
constexpr int kMaxSidePx = 4096;

struct Trailer {
  char magic[4];
  uint32_t deflated_size;
  uint32_t crc;
};

struct CloseHandle {
  void operator()(void* handle) const { tjDestroy(handle); }
};
struct FreeBuffer {
  void operator()(unsigned char* buffer) const { tjFree(buffer); }
};

[[noreturn]] void RefusePicture(const std::string& reason) {
  throw DamagedMap("stored picture tile: " + reason);
}

uint32_t ChecksumOf(const std::string& bytes) {
  return static_cast<uint32_t>(
      crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

std::string Jpeg(const cv::Mat4b& picture) {
  const std::unique_ptr<void, CloseHandle> handle(tjInitCompress());
  if (!handle) throw std::runtime_error("turbojpeg: no encoder");
  unsigned char* buffer = nullptr;
  unsigned long size = 0;
  const int status = tjCompress2(handle.get(),
                                 picture.ptr(),
                                 picture.cols,
                                 static_cast<int>(picture.step),
                                 picture.rows,
                                 TJPF_BGRA,
                                 &buffer,
                                 &size,
                                 TJSAMP_420,
                                 kQuality,
                                 0);
  const std::unique_ptr<unsigned char, FreeBuffer> owner(buffer);
  if (status != 0) throw std::runtime_error("picture tile: turbojpeg could not write it");
  return {reinterpret_cast<const char*>(buffer), size};
}

std::string AlphaOf(const cv::Mat4b& picture) {
  std::string alpha;
  for (const cv::Vec4b& pixel : picture) alpha.push_back(static_cast<char>(pixel[3]));
  return alpha;
}

bool IsOpaque(const std::string& alpha) {
  return alpha.find_first_not_of('\xff') == std::string::npos;
}

// Position behind the JPEG; its end if nothing follows.
size_t FindTrailer(const std::string& bytes) {
  const std::string end("\xff\xd9");
  const size_t at = bytes.rfind(end + std::string(kPictureMagic, sizeof(kPictureMagic)));
  return at == std::string::npos ? bytes.size() : at + end.size();
}

std::string ReadAlpha(const std::string& bytes, size_t position, size_t num_pixels) {
  Trailer trailer{};
  if (bytes.size() < position + sizeof(trailer)) RefusePicture("is cut short");
  std::memcpy(&trailer, bytes.data() + position, sizeof(trailer));
  position += sizeof(trailer);
  if (bytes.size() - position != trailer.deflated_size) RefusePicture("has an impossible size");
  std::string alpha(num_pixels, '\0');
  uLongf size = num_pixels;
  const int status = uncompress(reinterpret_cast<Bytef*>(alpha.data()),
                                &size,
                                reinterpret_cast<const Bytef*>(bytes.data() + position),
                                trailer.deflated_size);
  if (status != Z_OK || size != num_pixels) RefusePicture("does not inflate");
  if (ChecksumOf(alpha) != trailer.crc) RefusePicture("its checksum is wrong");
  return alpha;
}

cv::Mat4b ReadJpeg(const std::string& bytes, size_t size) {
  const std::unique_ptr<void, CloseHandle> handle(tjInitDecompress());
  if (!handle) throw std::runtime_error("turbojpeg: no decoder");
  const auto* const data = reinterpret_cast<const unsigned char*>(bytes.data());
  int width = 0, height = 0, subsampling = 0, colorspace = 0;
  if (tjDecompressHeader3(handle.get(), data, size, &width, &height, &subsampling, &colorspace) !=
      0) {
    RefusePicture(tjGetErrorStr2(handle.get()));
  }
  if (width > kMaxSidePx || height > kMaxSidePx) RefusePicture("is too large");
  cv::Mat4b picture(height, width);
  const int flags = TJFLAG_STOPONWARNING | TJFLAG_LIMITSCANS;
  if (tjDecompress2(handle.get(), data, size, picture.data, width, 0, height, TJPF_BGRA, flags) !=
      0) {
    RefusePicture(tjGetErrorStr2(handle.get()));
  }
  return picture;
}

}  // namespace

std::string SerializePhotoTile(const cv::Mat4b& picture) {
  std::string bytes = Jpeg(picture);
  const std::string alpha = AlphaOf(picture);
  if (IsOpaque(alpha)) return bytes;
  uLongf size = compressBound(alpha.size());
  std::string deflated(size, '\0');
  const int status = compress2(reinterpret_cast<Bytef*>(deflated.data()),
                               &size,
                               reinterpret_cast<const Bytef*>(alpha.data()),
                               alpha.size(),
                               Z_DEFAULT_COMPRESSION);
  if (status != Z_OK) throw std::runtime_error("picture tile: zlib could not deflate it");
  Trailer trailer{{}, static_cast<uint32_t>(size), ChecksumOf(alpha)};
  std::memcpy(trailer.magic, kPictureMagic, sizeof(kPictureMagic));
  bytes.append(reinterpret_cast<const char*>(&trailer), sizeof(trailer));
  return bytes.append(deflated, 0, size);
}

cv::Mat4b DeserializePhotoTile(const std::string& bytes) {
  const size_t end = FindTrailer(bytes);
  cv::Mat4b picture = ReadJpeg(bytes, end);
  if (end == bytes.size()) return picture;
  const std::string alpha = ReadAlpha(bytes, end, picture.total());
  size_t i = 0;
  for (cv::Vec4b& pixel : picture) pixel[3] = static_cast<uchar>(alpha[i++]);
  return picture;
}

}  // namespace freelsd
