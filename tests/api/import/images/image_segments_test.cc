// PNG files of which most is not pixels: geotags among it are found, the rest costs nothing.
#include "api/import/images/image_segments.h"

#include <doctest/doctest.h>
#include <opencv2/imgcodecs.hpp>
#include <zlib.h>

#include "api/import/images/images.h"
#include "tests/api/errors.h"

namespace freelsd {
namespace {

constexpr double kMaxPositionErrorDeg = 1e-9;
// Signature and IHDR: what may come anywhere comes behind.
constexpr size_t kHeaderEnd = 33;

std::string BigEndian(uint32_t value, int count) {
  std::string bytes;
  for (int i = count - 1; i >= 0; --i) bytes += static_cast<char>(value >> (8 * i));
  return bytes;
}

std::string Chunk(const std::string& type, const std::string& payload) {
  const std::string checked = type + payload;
  const uLong crc =
      crc32(0, reinterpret_cast<const Bytef*>(checked.data()), static_cast<uInt>(checked.size()));
  return BigEndian(static_cast<uint32_t>(payload.size()), 4) + checked +
         BigEndian(static_cast<uint32_t>(crc), 4);
}

cv::Mat3b Picture() { return cv::Mat3b(24, 32, cv::Vec3b(40, 90, 70)); }

std::string PngWith(const std::string& chunks) {
  std::vector<uchar> bytes;
  cv::imencode(".png", Picture(), bytes);
  const std::string png(bytes.begin(), bytes.end());
  return png.substr(0, kHeaderEnd) + chunks + png.substr(kHeaderEnd);
}

std::string Entry(uint32_t tag, uint32_t type, uint32_t count, const std::string& value) {
  return BigEndian(tag, 2) + BigEndian(type, 2) + BigEndian(count, 4) + value;
}

std::string Degrees(uint32_t degrees, uint32_t minutes) {
  return BigEndian(degrees, 4) + BigEndian(1, 4) + BigEndian(minutes, 4) + BigEndian(1, 4) +
         BigEndian(0, 4) + BigEndian(1, 4);
}

// 47 deg 30' N, 8 deg 15' E, 612 m, as a TIFF block with one directory in the other.
std::string ExifPosition() {
  using std::string_literals::operator""s;
  constexpr uint32_t kByte = 1, kText = 2, kLong = 4, kRational = 5;
  return "MM\0*"s + BigEndian(8, 4) + BigEndian(1, 2) + Entry(0x8825, kLong, 1, BigEndian(26, 4)) +
         BigEndian(0, 4) + BigEndian(6, 2) + Entry(1, kText, 2, "N\0\0\0"s) +
         Entry(2, kRational, 3, BigEndian(104, 4)) + Entry(3, kText, 2, "E\0\0\0"s) +
         Entry(4, kRational, 3, BigEndian(128, 4)) + Entry(5, kByte, 1, "\0\0\0\0"s) +
         Entry(6, kRational, 1, BigEndian(152, 4)) + BigEndian(0, 4) + Degrees(47, 30) +
         Degrees(8, 15) + BigEndian(612, 4) + BigEndian(1, 4);
}

std::string XmpPosition() {
  return std::string("XML:com.adobe.xmp\0\0\0\0\0", 22) +
         "<x:xmpmeta xmlns:x='adobe:ns:meta/'><rdf:RDF "
         "xmlns:rdf='http://www.w3.org/1999/02/22-rdf-syntax-ns#'><rdf:Description rdf:about='' "
         "xmlns:drone-dji='http://www.dji.com/drone-dji/1.0/' drone-dji:GpsLatitude='47.5' "
         "drone-dji:GpsLongitude='8.25' drone-dji:AbsoluteAltitude='612'/></rdf:RDF></x:xmpmeta>";
}

void CheckTaken(const std::string& png) {
  CHECK(cv::norm(DecodeImage(png, {}), Picture(), cv::NORM_INF) == 0.0);
  const ImageTags tags = ReadImageTags(png, SniffImage(png, {}));
  REQUIRE(tags.meta.position);
  CHECK(tags.meta.position->latitude_deg == doctest::Approx(47.5).epsilon(kMaxPositionErrorDeg));
  CHECK(tags.meta.position->longitude_deg == doctest::Approx(8.25).epsilon(kMaxPositionErrorDeg));
  CHECK(tags.meta.position->altitude_m == doctest::Approx(612.0));
}

TEST_CASE("PNG: a position in EXIF or XMP is read, also behind 40 000 texts or one of 2 MiB") {
  std::string many_texts;
  for (int i = 0; i < 40000; ++i) many_texts += Chunk("tEXt", std::string("a\0b", 3));
  const std::string long_text =
      Chunk("tEXt", std::string("a\0", 2) + std::string(size_t{2} << 20, 'b'));
  for (const std::string& texts : {std::string(), many_texts, long_text}) {
    CAPTURE(texts.size());
    CheckTaken(PngWith(texts + Chunk("eXIf", ExifPosition())));
    CheckTaken(PngWith(texts + Chunk("iTXt", XmpPosition())));
  }
}

TEST_CASE("PNG: a text whose checksum is wrong is damage, as in any other chunk") {
  std::string text = Chunk("tEXt", std::string("a\0b", 3));
  text[10] = 'c';
  CHECK(ErrorOf([&] { DecodeImage(PngWith(text), {}); }) == "422 DamagedImage");
}

TEST_CASE("PNG: of many transparencies the first alone reaches the decoder") {
  std::string transparencies;
  for (int i = 0; i < 1000; ++i) transparencies += Chunk("tRNS", std::string(6, '\0'));
  CHECK(DecodeImage(PngWith(transparencies), {}).size() == Picture().size());
}

TEST_CASE("PNG: chunks end with IEND, and where the bytes end within one") {
  const std::string png = PngWith(Chunk("tEXt", std::string("a\0b", 3)));
  const auto types = [](std::string_view bytes) {
    std::string text;
    PngChunks chunks(bytes);
    while (const auto chunk = chunks.Next()) text += std::string(chunk->type) + " ";
    return text;
  };
  CHECK(types(png) == "IHDR tEXt IDAT IEND ");
  CHECK(types(png + Chunk("tEXt", "a")) == "IHDR tEXt IDAT IEND ");
  CHECK(types(png.substr(0, png.size() - 1)) == "IHDR tEXt IDAT ");
  CHECK(types(png.substr(0, kHeaderEnd + 14)) == "IHDR ");
  CHECK(types(png.substr(0, 4)).empty());
}

}  // namespace
}  // namespace freelsd
