#include "api/import/images/image_camera.h"

#include <algorithm>
#include <cmath>

namespace freelsd {
namespace {

constexpr double kFilmWidthMm = 36.0;
// Focal lengths of aerial cameras in image widths. A tag outside this range is wrong.
constexpr double kMinFocalWidths = 0.2;
constexpr double kMaxFocalWidths = 20.0;
// Largest plausible factor between a focal length from the sensor's resolution and the 35 mm
// equivalent, which is rounded and refers to the diagonal for some makers.
constexpr double kMaxFocalDisagreement = 1.4;
// Width and height may have been rounded when the image was resized.
constexpr double kMaxScaleMismatch = 0.01;

// Image size over the size in EXIF; differs from 1 after resizing.
struct Resize {
  double factor = 1.0;
  std::vector<std::string> warnings;
};

Resize ResizeSinceExposure(const TagSource& tags, const ImageHeader& header) {
  double width = tags.ExifNumber("Exif.Photo.PixelXDimension").value_or(0.0);
  double height = tags.ExifNumber("Exif.Photo.PixelYDimension").value_or(0.0);
  Resize resize;
  if (width < 1.0 || height < 1.0) return resize;
  if ((width > height) != (header.width_px > header.height_px)) {
    std::swap(width, height);
    resize.warnings.emplace_back("the image was turned after exposure: its attitude may be wrong");
  }
  resize.factor = header.width_px / width;
  if (header.width_px == width && header.height_px == height) return resize;
  resize.warnings.emplace_back(
      "the image's size differs from its EXIF: the focal length is scaled with the width");
  if (std::abs(header.height_px / height / resize.factor - 1.0) > kMaxScaleMismatch) {
    resize.warnings.emplace_back(
        "the image was cropped after exposure: the camera's intrinsics are uncertain");
  }
  return resize;
}

// Pixels of the present image per millimetre of the sensor.
std::optional<double> PixelsPerMm(const TagSource& tags, const std::string& axis, double factor) {
  const std::optional<double> resolution =
      tags.ExifNumber("Exif.Photo.FocalPlane" + axis + "Resolution");
  if (!resolution || *resolution <= 0.0) return std::nullopt;
  // EXIF: 2 inch (default), 3 centimetre; TIFF/EP adds 4 millimetre, 5 micrometre.
  const double unit = tags.ExifNumber("Exif.Photo.FocalPlaneResolutionUnit").value_or(2.0);
  const double unit_mm = unit == 3.0 ? 10.0 : unit == 4.0 ? 1.0 : unit == 5.0 ? 1e-3 : 25.4;
  return factor * *resolution / unit_mm;
}

bool IsPlausible(double focal_px, const ImageHeader& header) {
  const double side = std::max(header.width_px, header.height_px);
  return std::isfinite(focal_px) && focal_px > kMinFocalWidths * side &&
         focal_px < kMaxFocalWidths * side;
}

Camera CenteredCamera(const ImageHeader& header, double focal_px) {
  Camera camera;
  camera.width_px = header.width_px;
  camera.height_px = header.height_px;
  camera.fx_px = camera.fy_px = focal_px;
  camera.cx_px = 0.5 * (header.width_px - 1);
  camera.cy_px = 0.5 * (header.height_px - 1);
  camera.source = CameraSource::kExif;
  return camera;
}

// Seconds from the first row to the last; 0 without tag. The tag is the time of one sensor row
// (nanoseconds in Pix4D's scheme), so the number of exposed rows multiplies it.
double ReadoutSeconds(const TagSource& tags, const ImageHeader& header, double factor) {
  constexpr double kNanosecond = 1e-9;
  constexpr double kMaxReadoutS = 0.5;
  const double row_s = kNanosecond * tags.XmpNumber("Camera", "LineReadoutTime").value_or(0.0);
  const double readout_s = row_s * header.height_px / factor;
  return readout_s > 0.0 && readout_s <= kMaxReadoutS ? readout_s : 0.0;
}

std::optional<Camera> CalibratedCamera(const TagSource& tags,
                                       const ImageHeader& header,
                                       double factor) {
  const std::optional<double> focal_mm = tags.XmpNumber("Camera", "PerspectiveFocalLength");
  const std::vector<double> principal_mm = tags.XmpNumbers("Camera", "PrincipalPoint");
  const std::vector<double> kkkpp = tags.XmpNumbers("Camera", "PerspectiveDistortion");
  const std::optional<double> x_per_mm = PixelsPerMm(tags, "X", factor);
  const std::optional<double> y_per_mm = PixelsPerMm(tags, "Y", factor);
  if (!focal_mm || principal_mm.size() != 2 || kkkpp.size() != 5 || !x_per_mm || !y_per_mm) {
    return std::nullopt;
  }
  Camera camera = CenteredCamera(header, *focal_mm * *x_per_mm);
  camera.fy_px = *focal_mm * *y_per_mm;
  // Millimetres count from the sensor's corner; ours count from the first pixel's centre.
  camera.cx_px = principal_mm[0] * *x_per_mm - 0.5;
  camera.cy_px = principal_mm[1] * *y_per_mm - 0.5;
  camera.distortion = DistortionModel::kRadTan;
  // From k1, k2, k3, p1, p2 to the order of OpenCV.
  camera.coefficients = {kkkpp[0], kkkpp[1], kkkpp[3], kkkpp[4], kkkpp[2]};
  camera.source = CameraSource::kCalibrated;
  const bool is_plausible = IsPlausible(camera.fx_px, header) &&
                            IsPlausible(camera.fy_px, header) &&
                            camera.IsInside({camera.cx_px, camera.cy_px});
  return is_plausible ? std::optional<Camera>(camera) : std::nullopt;
}

// The 35 mm equivalent refers to the longer side (36 mm), as used by DJI and others. In the
// standard it refers to the diagonal: 4 % more for 4:3. EXIF intrinsics are refined later.
std::optional<double> FocalFromEquivalent(const TagSource& tags, const ImageHeader& header) {
  const std::optional<double> equivalent = tags.ExifNumber("Exif.Photo.FocalLengthIn35mmFilm");
  if (!equivalent) return std::nullopt;
  const double focal_px = *equivalent / kFilmWidthMm * std::max(header.width_px, header.height_px);
  return IsPlausible(focal_px, header) ? std::optional<double>(focal_px) : std::nullopt;
}

std::optional<double> FocalFromSensor(const TagSource& tags,
                                      const ImageHeader& header,
                                      double factor) {
  const std::optional<double> focal_mm = tags.ExifNumber("Exif.Photo.FocalLength");
  const std::optional<double> per_mm = PixelsPerMm(tags, "X", factor);
  if (!focal_mm || !per_mm || !IsPlausible(*focal_mm * *per_mm, header)) return std::nullopt;
  return *focal_mm * *per_mm;
}

bool Agree(double a, double b) { return std::max(a, b) < kMaxFocalDisagreement * std::min(a, b); }

TaggedCamera ExifCamera(const TagSource& tags, const ImageHeader& header, double factor) {
  TaggedCamera tagged;
  std::optional<double> focal_px = FocalFromSensor(tags, header, factor);
  const std::optional<double> from_equivalent = FocalFromEquivalent(tags, header);
  if (focal_px && from_equivalent && !Agree(*focal_px, *from_equivalent)) {
    tagged.warnings.emplace_back(
        "the two focal lengths in EXIF disagree: the 35 mm equivalent is used");
    focal_px = from_equivalent;
  }
  if (!focal_px) focal_px = from_equivalent;
  if (focal_px) tagged.camera = CenteredCamera(header, *focal_px);
  return tagged;
}

}  // namespace

TaggedCamera CameraFromTags(const TagSource& tags, const ImageHeader& header) {
  const Resize resize = ResizeSinceExposure(tags, header);
  TaggedCamera tagged;
  if (tags.XmpText("Camera", "ModelType").value_or("perspective") != "perspective") {
    tagged.warnings.emplace_back("the lens is not perspective: its calibration is not supported");
    return tagged;
  }
  tagged.camera = CalibratedCamera(tags, header, resize.factor);
  if (!tagged.camera) {
    tagged = ExifCamera(tags, header, resize.factor);
    if (tags.XmpText("Camera", "PerspectiveFocalLength")) {
      tagged.warnings.emplace_back("the calibration in XMP is not complete or not plausible");
    }
  }
  if (!tagged.camera) {
    tagged.warnings.emplace_back("the image's tags give no focal length");
    return tagged;
  }
  tagged.camera->readout_s = ReadoutSeconds(tags, header, resize.factor);
  tagged.warnings.insert(tagged.warnings.end(), resize.warnings.begin(), resize.warnings.end());
  return tagged;
}

}  // namespace freelsd
