#include <doctest/doctest.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "api/import/images/image_segments.h"
#include "api/import/images/images.h"
#include "tests/api/errors.h"
#include "tests/api/flights.h"

namespace freelsd {
namespace {

constexpr double kMaxJpegErrorGrey = 12.0;

// Texture that compresses like a photograph, from a fixed seed.
cv::Mat3b Picture(int rows, int cols) {
  cv::Mat3b picture(rows, cols);
  uint32_t state = 1;
  for (int row = 0; row < rows; ++row) {
    for (int col = 0; col < cols; ++col) {
      state = state * 1664525u + 1013904223u;
      const auto noise = static_cast<uchar>((state >> 24) % 24);
      picture(row, col) =
          cv::Vec3b(static_cast<uchar>(60 + row), static_cast<uchar>(90 + col / 2), noise);
    }
  }
  return picture;
}

std::string Encoded(const std::string& extension,
                    const cv::Mat& image,
                    const std::vector<int>& how = {}) {
  std::vector<uchar> bytes;
  cv::imencode(extension, image, bytes, how);
  return {bytes.begin(), bytes.end()};
}

std::string ErrorOfDecoding(std::string_view bytes) {
  return ErrorOf([bytes] { DecodeImage(bytes, ImageLimits{}); });
}

std::string BigEndian(uint32_t value, int count) {
  std::string bytes;
  for (int i = count - 1; i >= 0; --i) bytes += static_cast<char>(value >> (8 * i));
  return bytes;
}

// With another size written into its frame header.
std::string WithJpegSize(std::string jpeg, uint32_t width, uint32_t height) {
  for (const JpegSegment& segment : JpegSegments(jpeg)) {
    if (!IsStartOfFrame(segment.marker)) continue;
    const auto at = static_cast<size_t>(segment.payload.data() - jpeg.data());
    return jpeg.replace(at + 1, 4, BigEndian(height, 2) + BigEndian(width, 2));
  }
  return jpeg;
}

TEST_CASE("decode: JPEG and PNG come as 8 bit BGR of their size") {
  const cv::Mat3b picture = Picture(60, 80);
  const std::string jpeg = Encoded(".jpg", picture);
  const cv::Mat from_jpeg = DecodeImage(jpeg, {});
  REQUIRE(from_jpeg.type() == CV_8UC3);
  CHECK(cv::norm(from_jpeg, picture, cv::NORM_L1) / (60 * 80 * 3) < kMaxJpegErrorGrey);
  const cv::Mat from_png = DecodeImage(Encoded(".png", picture), {});
  CHECK(cv::norm(from_png, picture, cv::NORM_INF) == 0.0);
  const ImageHeader header = SniffImage(jpeg, {});
  CHECK(header.is_jpeg);
  CHECK(header.width_px == 80);
  CHECK(header.height_px == 60);
}

TEST_CASE("decode: grey, alpha and progressive images come as BGR too") {
  const cv::Mat grey(20, 30, CV_8UC1, cv::Scalar(77));
  const cv::Mat alpha(20, 30, CV_8UC4, cv::Scalar(10, 20, 30, 0));
  CHECK(DecodeImage(Encoded(".jpg", grey), {}).at<cv::Vec3b>(5, 5) == cv::Vec3b(77, 77, 77));
  CHECK(DecodeImage(Encoded(".png", grey), {}).at<cv::Vec3b>(5, 5) == cv::Vec3b(77, 77, 77));
  CHECK(DecodeImage(Encoded(".png", alpha), {}).at<cv::Vec3b>(5, 5) == cv::Vec3b(10, 20, 30));
  const std::string progressive =
      Encoded(".jpg", Picture(60, 80), {cv::IMWRITE_JPEG_PROGRESSIVE, 1});
  CHECK(DecodeImage(progressive, {}).cols == 80);
}

TEST_CASE("decode: a PNG of one bit is black and white") {
  cv::Mat1b halves(20, 30, uint8_t{0});
  halves.colRange(15, 30).setTo(255);
  const cv::Mat image = DecodeImage(Encoded(".png", halves, {cv::IMWRITE_PNG_BILEVEL, 1}), {});
  CHECK(image.at<cv::Vec3b>(5, 14) == cv::Vec3b(0, 0, 0));
  CHECK(image.at<cv::Vec3b>(5, 15) == cv::Vec3b(255, 255, 255));
}

TEST_CASE("decode: EXIF orientation is ignored, intrinsics belong to the sensor") {
  const std::string jpeg = Encoded(".jpg", Picture(60, 80));
  // Orientation 6 (turn by 90 deg) in a minimal little-endian TIFF block.
  const std::string exif("Exif\0\0II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0\x06\0\0\0\0\0\0\0",
                         32);
  const std::string turned = jpeg.substr(0, 2) + "\xFF\xE1" +
                             BigEndian(static_cast<uint32_t>(exif.size() + 2), 2) + exif +
                             jpeg.substr(2);
  const cv::Mat image = DecodeImage(turned, {});
  CHECK(image.cols == 80);
  CHECK(image.rows == 60);
}

TEST_CASE("decode: a JPEG cut anywhere is refused, and the next good one is taken") {
  const std::string jpeg = Encoded(".jpg", Picture(120, 160));
  int num_refused = 0;
  for (size_t percent = 1; percent < 100; ++percent) {
    const std::string error = ErrorOfDecoding(jpeg.substr(0, jpeg.size() * percent / 100));
    num_refused += error == "422 DamagedImage" || error == "415 UnsupportedImage" ? 1 : 0;
  }
  CHECK(num_refused == 99);
  CHECK(ErrorOfDecoding(jpeg.substr(0, jpeg.size() - 8)) == "422 DamagedImage");
  CHECK(ErrorOfDecoding(jpeg) == "nothing");
}

// The start of the first scan's entropy-coded data.
size_t ScanAt(const std::string& jpeg) {
  const size_t at = jpeg.find("\xFF\xDA");
  return at + 2 + BigEndian16(jpeg, at + 2);
}

TEST_CASE("decode: a JPEG that is whole is taken in spite of what surrounds its pixels") {
  const cv::Mat picture = Picture(120, 160);
  const std::string jpeg = Encoded(".jpg", picture);
  const std::string progressive = Encoded(".jpg", picture, {cv::IMWRITE_JPEG_PROGRESSIVE, 1});
  const std::string restarts = Encoded(".jpg", picture, {cv::IMWRITE_JPEG_RST_INTERVAL, 3});
  const std::string body = jpeg.substr(0, jpeg.size() - 2), end("\xFF\xD9");
  std::string bad_scan = jpeg;
  bad_scan[ScanAt(jpeg) - 2] = '\0';  // Se
  std::string garbage = jpeg;
  garbage.insert(2, std::string(5, '\0'));
  std::string garbage_later = jpeg;
  garbage_later.insert(jpeg.find("\xFF\xDB"), "junk");
  const std::vector<std::pair<std::string, std::string>> variants{
      {"scan parameters", bad_scan},
      {"no end", body},
      {"no end, progressive", progressive.substr(0, progressive.size() - 2)},
      {"no end, restarts", restarts.substr(0, restarts.size() - 2)},
      {"half an end", jpeg.substr(0, jpeg.size() - 1)},
      {"bytes before the end", body + std::string(4, '\x11') + end},
      {"zeros before the end", body + std::string(40, '\0') + end},
      {"zeros instead of the end", body + std::string(40, '\0')},
      {"two ends", jpeg + end},
      {"much behind the end", jpeg + std::string(8192, 'x')},
      {"bytes before the first marker", garbage},
      {"bytes between markers", garbage_later},
      {"fill bytes", jpeg.substr(0, 2) + "\xFF\xFF\xFF" + jpeg.substr(2)}};
  const cv::Mat wanted = DecodeImage(jpeg, {});
  for (const auto& variant : variants) {
    const std::string& bytes = variant.second;
    INFO(variant.first);
    CHECK(ErrorOfDecoding(bytes) == "nothing");
    if (ErrorOfDecoding(bytes) != "nothing" || variant.first.find(',') != std::string::npos)
      continue;
    CHECK(cv::norm(DecodeImage(bytes, {}), wanted, cv::NORM_INF) == 0.0);
  }
}

TEST_CASE("decode: a scan without an end that itself ends with a zero is whole") {
  // No colour takes no bits but zeros.
  cv::Mat grey;
  cv::cvtColor(Picture(120, 160), grey, cv::COLOR_BGR2GRAY);
  int num_tried = 0;
  for (int corner = 0; corner < 256; ++corner) {
    grey.at<uchar>(119, 159) = static_cast<uchar>(corner);
    cv::Mat picture;
    cv::cvtColor(grey, picture, cv::COLOR_GRAY2BGR);
    const std::string jpeg = Encoded(".jpg", picture);
    const std::string body = jpeg.substr(0, jpeg.size() - 2);
    if (body.back() != '\0') continue;
    ++num_tried;
    REQUIRE(ErrorOfDecoding(body) == "nothing");
    CHECK(cv::norm(DecodeImage(body, {}), DecodeImage(jpeg, {}), cv::NORM_INF) == 0.0);
  }
  CHECK(num_tried > 0);
}

TEST_CASE("decode: of a JPEG that is cut, the missing share is told") {
  const cv::Mat picture = Picture(128, 160);
  for (const std::string& jpeg :
       {Encoded(".jpg", picture), Encoded(".jpg", picture, {cv::IMWRITE_JPEG_RST_INTERVAL, 3})}) {
    const size_t half = (ScanAt(jpeg) + jpeg.size()) / 2;
    for (const std::string& bytes :
         {jpeg.substr(0, half),
          jpeg.substr(0, half) + "\xFF\xD9",
          jpeg.substr(0, half) + std::string(jpeg.size() - half, '\0')}) {
      std::string why;
      try {
        DecodeImage(bytes, {});
      } catch (const ApiError& error) {
        why = error.what();
      }
      CAPTURE(why);
      CHECK((why.find("of 128 rows are missing") != std::string::npos ||
             why.find("damaged") != std::string::npos));
    }
  }
}

TEST_CASE("decode: a PNG cut or with a flipped bit anywhere is refused") {
  const std::string png = Encoded(".png", Picture(40, 50));
  for (size_t size = 0; size < png.size(); size += 7) {
    CAPTURE(size);
    CHECK(ErrorOfDecoding(png.substr(0, size)) != "nothing");
  }
  CHECK(ErrorOfDecoding(png.substr(0, png.size() - 1)) == "422 DamagedImage");
  for (size_t at = 8; at < png.size(); at += 11) {
    std::string flipped = png;
    flipped[at] = static_cast<char>(flipped[at] ^ 0x10);
    CAPTURE(at);
    CHECK(ErrorOfDecoding(flipped) != "nothing");
  }
}

TEST_CASE("decode: what is neither JPEG nor PNG is 415, whatever it is") {
  for (const std::string& bytes : {std::string(),
                                   std::string("GIF89a"),
                                   std::string("II*\0", 4),
                                   std::string("\xFF\xD8"),
                                   std::string("RIFF....WEBP"),
                                   Encoded(".bmp", Picture(4, 4))}) {
    CHECK(ErrorOfDecoding(bytes) == "415 UnsupportedImage");
  }
}

TEST_CASE("decode: a header of 30000x30000 is refused before anything is allocated") {
  const std::string jpeg = WithJpegSize(Encoded(".jpg", Picture(16, 16)), 30000, 30000);
  try {
    DecodeImage(jpeg, {});
    FAIL("must throw");
  } catch (const ApiError& error) {
    CHECK(error.code() == "ImageTooLarge");
    CHECK(error.http_status() == 413);
    CHECK(error.limit == 64e6);
    CHECK(error.observed == 9e8);
  }
  CHECK(ErrorOfDecoding(WithJpegSize(jpeg, 20000, 100)) == "413 ImageTooLarge");
  CHECK(ErrorOfDecoding(WithJpegSize(jpeg, 0, 100)) == "422 DamagedImage");
  CHECK(ErrorOf([&] { SniffImage(jpeg, {64.0, 16384, 10}); }) == "413 ImageTooLarge");
}

TEST_CASE("decode: a JPEG whose header promises more rows than it has is refused") {
  const std::string jpeg = WithJpegSize(Encoded(".jpg", Picture(120, 160)), 160, 400);
  CHECK(ErrorOfDecoding(jpeg) == "422 DamagedImage");
}

TEST_CASE("decode: 16 bits per channel are refused") {
  const cv::Mat deep(10, 10, CV_16UC3, cv::Scalar(1, 2, 3));
  CHECK(ErrorOfDecoding(Encoded(".png", deep)) == "422 UnsupportedPixels");
}

TEST_CASE("decode: every photograph of the recorded flights is taken, and none of their halves") {
  const auto flights = FlightsFolder();
  if (!flights) return;
  int num_photographs = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(*flights)) {
    const std::string extension = entry.path().extension().string();
    if (extension != ".JPG" && extension != ".jpg") continue;
    const std::string bytes = ReadBytes(entry.path());
    CAPTURE(entry.path());
    CHECK(ErrorOfDecoding(bytes) == "nothing");
    if (num_photographs % 16 == 0) {
      CHECK(ErrorOfDecoding(bytes.substr(0, bytes.size() / 2)) == "422 DamagedImage");
    }
    ++num_photographs;
  }
  CHECK(num_photographs == 126);
}

}  // namespace
}  // namespace freelsd
