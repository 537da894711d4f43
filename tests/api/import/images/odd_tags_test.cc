// Tags as programs and cameras write them in spite of their formats. Every one gives the right
// value, or a sentence that names it.
#include <doctest/doctest.h>
#include <opencv2/imgcodecs.hpp>

#include "api/import/gimbal.h"
#include "api/import/images/images.h"
#include "tests/api/import/images/tagged_image.h"

namespace freelsd {
namespace {

constexpr double kMaxPositionErrorDeg = 1e-7;
constexpr double kMaxRotationErrorRad = 1e-6;

std::string PlainJpeg() {
  std::vector<uchar> bytes;
  cv::imencode(".jpg", cv::Mat(48, 64, CV_8UC3, cv::Scalar(80, 90, 100)), bytes);
  return {bytes.begin(), bytes.end()};
}

ImageTags Read(const std::string& bytes) {
  return ReadImageTags(bytes, SniffImage(bytes, ImageLimits{}));
}

bool Tells(const ImageTags& tags, const std::string& words) {
  for (const std::string& warning : tags.warnings) {
    if (warning.find(words) != std::string::npos) return true;
  }
  return false;
}

// --- XMP that is not well-formed ---

constexpr char kXmpHead[] =
    "<x:xmpmeta xmlns:x='adobe:ns:meta/'><rdf:RDF "
    "xmlns:rdf='http://www.w3.org/1999/02/22-rdf-syntax-ns#'><rdf:Description rdf:about='' "
    "xmlns:tiff='http://ns.adobe.com/tiff/1.0/' "
    "xmlns:drone-dji='http://www.dji.com/drone-dji/1.0/' ";
constexpr char kGimbal[] =
    "drone-dji:GimbalYawDegree='+38.0' drone-dji:GimbalPitchDegree='-90.0' "
    "drone-dji:GimbalRollDegree='+0.0' ";
constexpr char kRest[] = "drone-dji:RelativeAltitude='+98.0' drone-dji:AltitudeType='RtkAlt' ";
constexpr char kXmpTail[] = "></rdf:Description></rdf:RDF></x:xmpmeta>";

ImageTags WithPacket(const std::string& packet, const std::string& jpeg) {
  const std::string header("http://ns.adobe.com/xap/1.0/\0", 29);
  return Read(WithSegment(jpeg, header + packet));
}

ImageTags WithPacket(const std::string& packet) {
  return WithPacket(packet, WithGeotag(PlainJpeg(), {}));
}

bool HasAll(const ImageTags& tags) {
  const EulerAngles nadir{0.0, RadFromDeg(-90.0), RadFromDeg(38.0)};
  return tags.meta.ned_from_camera &&
         AngleBetween(*tags.meta.ned_from_camera, NedFromGimbalCamera(nadir)) <
             kMaxRotationErrorRad &&
         tags.meta.height_above_ground_m == 98.0 && tags.meta.altitude_datum == "ellipsoid";
}

std::string Packet(const std::string& attributes) { return kXmpHead + attributes + kXmpTail; }

TEST_CASE("odd tags: XMP that is not well-formed is read as far as it can be") {
  const std::string whole = std::string(kGimbal) + kRest;
  std::string utf16("\xFF\xFE", 2);
  for (const char c : Packet(whole)) utf16 += std::string(1, c) + std::string(1, '\0');
  std::string utf16_big;
  for (const char c : Packet(whole)) utf16_big += std::string(1, '\0') + std::string(1, c);
  const std::string elements =
      std::string(kXmpHead) + kRest +
      "><drone-dji:GimbalYawDegree>+38.0</drone-dji:GimbalYawDegree><drone-dji:GimbalPitchDegree>"
      "<![CDATA[-90.0]]></drone-dji:GimbalPitchDegree></rdf:Description></rdf:RDF></x:xmpmeta>";
  const std::vector<std::pair<std::string, std::string>> packets{
      {"well-formed", Packet(whole)},
      {"a property twice", Packet(whole + "tiff:Make='DJI' tiff:Make='DJI'")},
      {"a property as attribute and element",
       kXmpHead + whole +
           "><drone-dji:GimbalYawDegree>+38.0</drone-dji:GimbalYawDegree></rdf:Description>"
           "</rdf:RDF></x:xmpmeta>"},
      {"NUL at the end", Packet(whole) + std::string(20, '\0')},
      {"NUL in a value", Packet(whole + "tiff:Make='DJI" + std::string(2, '\0') + "'")},
      {"a comment", "<!-- made by a tool -->" + Packet(whole)},
      {"an ampersand", Packet("tiff:Make='Drones & Sons' " + whole)},
      {"a byte of latin-1", Packet("tiff:Make='M\xFCller' " + whole)},
      {"a control byte", Packet("tiff:Make='\x01' " + whole)},
      {"UTF-16, little-endian", utf16},
      {"UTF-16, big-endian, without a mark", utf16_big},
      {"a namespace that is not declared", Packet(whole + "GPano:Use='True' ")},
      {"an end that is missing", kXmpHead + whole + ">"},
      {"an end tag too many", Packet(whole) + "</x:xmpmeta>"},
      {"bytes before the packet", " \n\xEF\xBB\xBF" + Packet(whole)},
      {"a processing instruction within",
       "<?xpacket begin='' id='W5M0MpCehiHzreSzNTczkc9d'?>" + Packet(whole) + "<?xpacket end='w'"},
      {"elements and CDATA", elements},
      {"decimal commas",
       Packet("drone-dji:GimbalYawDegree='+38,0' drone-dji:GimbalPitchDegree='-90,0' "
              "drone-dji:GimbalRollDegree='0,0' drone-dji:RelativeAltitude='+98,00' "
              "drone-dji:AltitudeType='RtkAlt'")},
      {"another prefix",
       "<x:xmpmeta xmlns:x='adobe:ns:meta/'><rdf:RDF "
       "xmlns:rdf='http://www.w3.org/1999/02/22-rdf-syntax-ns#'><rdf:Description "
       "xmlns:ns1='http://www.dji.com/drone-dji/1.0/' ns1:GimbalYawDegree='38' "
       "ns1:GimbalPitchDegree='-90' ns1:RelativeAltitude='98' ns1:AltitudeType='RtkAlt'/>"
       "</rdf:RDF></x:xmpmeta>"},
  };
  for (const auto& variant : packets) {
    const auto& packet = variant.second;
    INFO(variant.first);
    CHECK(HasAll(WithPacket(packet)));
  }
}

TEST_CASE("odd tags: XMP that cannot be read is told") {
  const std::string whole = std::string(kGimbal) + kRest;
  const std::vector<std::pair<std::string, std::string>> packets{
      {"no XML", "drone-dji:GimbalYawDegree=38"},
      {"cut within the first tag", std::string(kXmpHead).substr(0, 60)},
      {"entities", "<!DOCTYPE x [<!ENTITY a 'aaaa'>]>" + Packet(whole)},
      {"cut within the properties", (kXmpHead + whole).substr(0, sizeof(kXmpHead) + 60)},
      {"a property twice, with two values", Packet(whole + "drone-dji:GimbalYawDegree='-120.0'")}};
  for (const auto& variant : packets) {
    const auto& packet = variant.second;
    INFO(variant.first);
    CHECK(Tells(WithPacket(packet), "XMP"));
  }
  for (const std::string name :
       {"GimbalPitchDegree", "GimbalYawDegree", "RelativeAltitude", "AbsoluteAltitude"}) {
    CAPTURE(name);
    CHECK(Tells(WithPacket(Packet("drone-dji:" + name + "='unknown'")), name));
  }
  std::string broken_exif("Exif\0\0XX*\0", 10);
  CHECK(Tells(Read(WithSegment(PlainJpeg(), broken_exif + std::string(40, 'x'))), "EXIF"));
}

// --- Hemispheres ---

struct Ref {
  std::string what;
  TiffTag tag;
};

ImageTags WithLatitudeRef(const std::vector<TiffTag>& ref) {
  std::vector<TiffTag> gps = ref;
  gps.push_back(RationalTag(2, {{47, 1}, {21, 1}, {36, 10}}));
  gps.push_back(AsciiTag(3, "E"));
  gps.push_back(RationalTag(4, {{8, 1}, {30, 1}, {0, 1}}));
  gps.push_back({5, kByteType, 1, LittleEndian(0, 1)});
  gps.push_back(RationalTag(6, {{555, 1}}));
  return Read(WithExif(PlainJpeg(), gps, {}));
}

TEST_CASE("odd tags: every form of a hemisphere is read, or refused with its name") {
  constexpr double kLatitudeDeg = 47.351;
  for (const std::string south : {"S", "s", "South", " S", "SOUTH"}) {
    CAPTURE(south);
    const ImageTags tags = WithLatitudeRef({AsciiTag(1, south)});
    CHECK((tags.meta.position &&
           std::abs(tags.meta.position->latitude_deg + kLatitudeDeg) < kMaxPositionErrorDeg));
  }
  for (const std::string north : {"N", "n", "North"}) {
    CAPTURE(north);
    const ImageTags tags = WithLatitudeRef({AsciiTag(1, north)});
    CHECK((tags.meta.position &&
           std::abs(tags.meta.position->latitude_deg - kLatitudeDeg) < kMaxPositionErrorDeg));
  }
  const std::vector<std::pair<std::string, std::vector<TiffTag>>> unknown{
      {"missing", {}},
      {"empty", {AsciiTag(1, "")}},
      {"the byte 1", {{1, kAsciiType, 2, std::string("\x01\0", 2)}}},
      {"a number", {{1, kByteType, 1, std::string("\x01")}}},
      {"of the other axis", {AsciiTag(1, "W")}},
      {"a word", {AsciiTag(1, "unknown")}},
      {"a sign", {AsciiTag(1, "-")}}};
  for (const auto& variant : unknown) {
    const auto& ref = variant.second;
    INFO(variant.first);
    const ImageTags tags = WithLatitudeRef(ref);
    CHECK((!tags.meta.position && Tells(tags, "GPSLatitudeRef")));
  }
}

TEST_CASE("odd tags: XMP tells the hemisphere where EXIF does not, and contradictions are told") {
  const auto read = [](const std::vector<TiffTag>& ref, const std::string& xmp) {
    std::vector<TiffTag> gps = ref;
    gps.push_back(RationalTag(2, {{33, 1}, {30, 1}, {0, 1}}));
    gps.push_back(AsciiTag(3, "E"));
    gps.push_back(RationalTag(4, {{151, 1}, {0, 1}, {0, 1}}));
    gps.push_back(RationalTag(6, {{100, 1}}));
    return Read(WithXmpTags(WithExif(PlainJpeg(), gps, {}), xmp));
  };
  const std::string south = "drone-dji:GpsLatitude='-33.5' drone-dji:GpsLongitude='151.0'";
  for (const ImageTags& tags : {read({}, south), read({AsciiTag(1, "\x01")}, south)}) {
    CHECK((tags.meta.position && tags.meta.position->latitude_deg == -33.5));
    CHECK(Tells(tags, "GPSLatitudeRef"));
  }
  const ImageTags both = read({AsciiTag(1, "N")}, south);
  CHECK((!both.meta.position && Tells(both, "hemisphere")));
  CHECK(Tells(read({AsciiTag(1, "S")}, "drone-dji:GpsLatitude='-34.5'"), "XMP"));
}

TEST_CASE("odd tags: degrees, minutes and seconds that cannot be are refused") {
  const auto read = [](const TiffTag& latitude) {
    return Read(WithExif(PlainJpeg(),
                         {AsciiTag(1, "N"),
                          latitude,
                          AsciiTag(3, "E"),
                          RationalTag(4, {{8, 1}, {30, 1}, {0, 1}}),
                          RationalTag(6, {{555, 1}})},
                         {}));
  };
  for (const auto& parts : std::vector<std::vector<std::pair<uint32_t, uint32_t>>>{
           {{4735100, 100000}, {21, 1}, {36, 10}},  // degrees already hold minutes and seconds
           {{47, 1}, {2106, 100}, {36, 10}},        // minutes already hold seconds
           {{47, 1}, {75, 1}, {0, 1}},
           {{47, 1}, {21, 1}, {3600, 1}},
           {{47, 1}, {21, 0}, {3600, 1000}}}) {
    const ImageTags tags = read(RationalTag(2, parts));
    CHECK((!tags.meta.position && Tells(tags, "GPSLatitude")));
  }
  const ImageTags sixty = read(RationalTag(2, {{47, 1}, {20, 1}, {60, 1}}));
  CHECK((sixty.meta.position &&
         std::abs(sixty.meta.position->latitude_deg - 47.35) < kMaxPositionErrorDeg));
}

// --- Altitudes ---

TEST_CASE("odd tags: of two altitudes that disagree the plausible one is used, and told") {
  struct Variant {
    std::string what;
    double exif_m;
    uint32_t reference;
    std::string xmp;
  };
  const std::vector<Variant> variants{{"zero", 0.0, 0, "+555.0"},
                                      {"zero below the sea", 0.0, 1, "+555.0"},
                                      {"below, and XMP above", 555.0, 1, "+555.0"},
                                      {"the sign of a small one", 30.0, 1, "+30.2"},
                                      {"an unsigned wrap", 4294411.0, 0, "555.0"},
                                      {"an unsigned wrap of decimetres", 6498.0, 0, "555.0"},
                                      {"feet", 1820.9, 0, "555.0"}};
  for (const Variant& variant : variants) {
    CAPTURE(variant.what);
    const ImageTags tags =
        Read(WithXmpTags(WithGeotag(PlainJpeg(), {47.0, 8.0, variant.exif_m, variant.reference}),
                         "drone-dji:AbsoluteAltitude='" + variant.xmp + "'"));
    const double wanted_m = std::stod(variant.xmp);
    CHECK((tags.meta.position && tags.meta.position->altitude_m == wanted_m &&
           Tells(tags, "AbsoluteAltitude")));
  }
}

TEST_CASE("odd tags: an altitude of XMP in feet is not used") {
  const ImageTags tags = Read(WithXmpTags(WithGeotag(PlainJpeg(), {47.0, 8.0, 555.0, 0}),
                                          "drone-dji:AbsoluteAltitude='1820.9'"));
  CHECK((tags.meta.position && tags.meta.position->altitude_m == 555.0 && Tells(tags, "feet")));
}

TEST_CASE("odd tags: a place that stands in the EXIF schema of XMP alone is read") {
  const ImageTags tags = WithPacket(
      Packet("xmlns:exif='http://ns.adobe.com/exif/1.0/' exif:GPSLatitude='33,30.6S' "
             "exif:GPSLongitude='151,12,36E' exif:GPSAltitude='5551/10' exif:GPSAltitudeRef='0' "),
      PlainJpeg());
  REQUIRE(tags.meta.position);
  CHECK(std::abs(tags.meta.position->latitude_deg + 33.51) < kMaxPositionErrorDeg);
  CHECK(std::abs(tags.meta.position->longitude_deg - 151.21) < kMaxPositionErrorDeg);
  CHECK(tags.meta.position->altitude_m == 555.1);
}

TEST_CASE("odd tags: an altitude that cannot be is refused, a rare one is told") {
  struct Variant {
    std::string what;
    double exif_m;
    uint32_t reference;
    bool is_used;
  };
  const std::vector<Variant> variants{{"zero without another", 0.0, 0, false},
                                      {"below all land", 555.0, 1, false},
                                      {"below the sea", 300.0, 1, true}};
  for (const Variant& variant : variants) {
    CAPTURE(variant.what);
    const ImageTags tags =
        Read(WithGeotag(PlainJpeg(), {47.0, 8.0, variant.exif_m, variant.reference}));
    CHECK((tags.meta.position.has_value() == variant.is_used && Tells(tags, "GPSAltitude")));
  }
  // The reference as text, as digits of text, and one of the future.
  const auto read = [](const TiffTag& reference) {
    return Read(WithExif(PlainJpeg(),
                         {AsciiTag(1, "N"),
                          RationalTag(2, {{31, 1}, {30, 1}, {0, 1}}),
                          AsciiTag(3, "E"),
                          RationalTag(4, {{35, 1}, {30, 1}, {0, 1}}),
                          reference,
                          RationalTag(6, {{400, 1}})},
                         {}));
  };
  const auto altitude = [](const ImageTags& tags) {
    return tags.meta.position ? tags.meta.position->altitude_m : 0.0;
  };
  CHECK(altitude(read(AsciiTag(5, "1"))) == -400.0);
  CHECK(altitude(read({5, kByteType, 1, std::string("1")})) == -400.0);
  CHECK(altitude(read({5, kByteType, 1, std::string("0")})) == 400.0);
  CHECK(Tells(read({5, kByteType, 1, std::string("\x07")}), "GPSAltitudeRef"));
}

// --- Angles of another convention ---

TEST_CASE("odd tags: angles that no aircraft flies are another convention's") {
  const auto nadir = [](const ImageTags& tags) {
    return tags.meta.ned_from_camera &&
           (*tags.meta.ned_from_camera * Eigen::Vector3d::UnitZ()).z() > 0.999;
  };
  const ImageTags autel =
      Read(WithXmpTags(PlainJpeg(), "Camera:Yaw='38' Camera:Pitch='-90' Camera:Roll='0'"));
  CHECK((nadir(autel) && Tells(autel, "Camera:Pitch")));
  const ImageTags no_roll = Read(WithXmpTags(PlainJpeg(), "Camera:Yaw='38' Camera:Pitch='-90'"));
  CHECK((nadir(no_roll) && Tells(no_roll, "Camera:Pitch")));
  const ImageTags oblique =
      Read(WithXmpTags(WithExif(PlainJpeg(), {}, {}, {AsciiTag(0x10f, "Autel Robotics")}),
                       "Camera:Yaw='38' Camera:Pitch='-40' Camera:Roll='0'"));
  const EulerAngles looks{0.0, RadFromDeg(-40.0), RadFromDeg(38.0)};
  CHECK((oblique.meta.ned_from_camera &&
         AngleBetween(*oblique.meta.ned_from_camera, NedFromGimbalCamera(looks)) <
             kMaxRotationErrorRad));
  for (const char* const zeros :
       {"drone-dji:GimbalYawDegree='+0.00' drone-dji:GimbalPitchDegree='0' "
        "drone-dji:GimbalRollDegree='-0.0'",
        "drone-parrot:CameraYawDegree='0' drone-parrot:CameraPitchDegree='0' "
        "drone-parrot:CameraRollDegree='0'",
        "Camera:Yaw='0' Camera:Pitch='0' Camera:Roll='0'"}) {
    CAPTURE(std::string(zeros));
    const ImageTags tags = Read(WithXmpTags(PlainJpeg(), zeros));
    CHECK((!tags.meta.ned_from_camera && !tags.meta.ned_from_body && Tells(tags, "all 0")));
  }
  for (const char* const tilted : {"Camera:Yaw='10' Camera:Pitch='90' Camera:Roll='0'",
                                   "Camera:Yaw='10' Camera:Pitch='0' Camera:Roll='180'"}) {
    CAPTURE(std::string(tilted));
    const ImageTags tags = Read(WithXmpTags(PlainJpeg(), tilted));
    CHECK((!tags.meta.ned_from_camera && !tags.meta.ned_from_body && Tells(tags, "Camera:")));
  }
}

// --- Times ---

TEST_CASE("odd tags: a date that stands elsewhere is used, one of a rolled-over week mended") {
  constexpr int64_t kNoonUs = int64_t{1717243200} * 1000000;  // 2024-06-01 12:00 UTC
  const auto with_times = [](const std::string& taken, const std::string& gps_date) {
    PhotoTimes times;
    times.taken = taken;
    times.gps_date = gps_date;
    if (!gps_date.empty()) times.gps_time = {12, 0, 0};
    return Read(WithGeotag(PlainJpeg(), {}, times));
  };
  const ImageTags modified =
      Read(WithExif(PlainJpeg(), {}, {}, {AsciiTag(0x132, "2024:06:01 12:00:00")}));
  CHECK(modified.meta.timestamp_us == kNoonUs);
  const ImageTags zeros = Read(WithExif(PlainJpeg(),
                                        {},
                                        {AsciiTag(0x9003, "0000:00:00 00:00:00")},
                                        {AsciiTag(0x132, "2024:06:01 12:00:00")}));
  CHECK(zeros.meta.timestamp_us == kNoonUs);
  const ImageTags modified_xmp =
      Read(WithXmpTags(PlainJpeg(), "xmp:ModifyDate='2024-06-01T14:00:00+02:00'"));
  CHECK(modified_xmp.meta.timestamp_us == kNoonUs);
  // 1024 weeks before.
  const ImageTags rolled = with_times("2024:06:01 14:00:00", "2004:10:16");
  CHECK((rolled.meta.timestamp_us == kNoonUs && Tells(rolled, "1024 weeks")));
  const ImageTags local = with_times("2024:06:01 14:00:00", "2024:06:01");
  CHECK((local.meta.timestamp_us == kNoonUs && local.meta.time_source == TimeSource::kGps));
  const ImageTags dashes = with_times("2024:06:01 14:00:00", "2024-06-01");
  CHECK(dashes.meta.timestamp_us == kNoonUs);
  CHECK_FALSE(with_times("0000:00:00 00:00:00", "").meta.timestamp_us);
  CHECK_FALSE(with_times("    :  :     :  :  ", "").meta.timestamp_us);
}

}  // namespace
}  // namespace freelsd
