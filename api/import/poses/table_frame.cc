// What is common to the lines of a table: its columns, and what their names leave open.
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "api/import/number_text.h"
#include "api/import/poses/pose_line.h"
#include "api/import/poses/side_files.h"

namespace freelsd {
namespace {

// Aircraft and cameras that look down tilt less. Of larger angles the convention is another one.
constexpr double kMaxTiltDeg = 45.0;
// No flight rolls as much all the time.
constexpr double kMaxSteadyRollDeg = 15.0;
constexpr size_t kMinNumZeroAngles = 3;
// Lines whose places are compared with the photographs' own.
constexpr size_t kNumComparedLines = 20;

std::vector<std::string> AssumptionsOf(const PoseColumns& header) {
  std::vector<std::string> warnings;
  const auto has = [&header](PoseField field) { return header.Has(field); };
  if (has(PoseField::kHeightAboveTakeOff) && !has(PoseField::kHeightAboveGround)) {
    warnings.emplace_back("height above take-off is used as height above ground");
  }
  const bool has_heading = has(PoseField::kYaw) || has(PoseField::kImageUpHeading);
  const bool has_tilt = has(PoseField::kGimbalPitch) || has(PoseField::kQuaternionW) ||
                        (has(PoseField::kRoll) && has(PoseField::kPitch));
  if (has_heading && !has_tilt) {
    warnings.emplace_back("only headings are given: roll and pitch are assumed level");
  }
  const auto wind = header.columns.find(PoseField::kWindFrom);
  if (wind != header.columns.end() && wind->second.name.find("from") == std::string::npos) {
    warnings.push_back("column \"" + wind->second.name + "\" is read as where the wind comes from");
  }
  // Altitudes are not converted: a flight has one datum of all its altitudes.
  if (const std::optional<std::string> datum = header.AltitudeDatum()) {
    warnings.push_back("column \"" + header.columns.at(PoseField::kAltitude).name +
                       "\" is of the datum " + *datum);
  }
  if (has(PoseField::kWindFrom) && has(PoseField::kWindTo)) {
    warnings.emplace_back(
        "where the wind comes from is used; where it blows to is used only if that is empty");
  }
  const auto time = header.columns.find(PoseField::kTime);
  const bool is_date = time != header.columns.end() && !time->second.unit;
  if (is_date && time->second.name.find("utc") == std::string::npos) {
    warnings.emplace_back("times of column \"" + time->second.name + "\" are read as UTC");
  }
  return warnings;
}

double DegreesBetween(const GeoPoint& a, const GeoPoint& b) {
  return std::hypot(a.latitude_deg - b.latitude_deg,
                    std::remainder(a.longitude_deg - b.longitude_deg, 360.0));
}

// Sizes of the column's numbers, degrees; zeros if it has none.
struct Sizes {
  double median = 0.0;
  double largest = 0.0;
};

Sizes SizesOf(const TableFrame& frame, const Table& table, PoseField field) {
  std::vector<double> sizes;
  for (const TableLine& line : table.lines) {
    const std::optional<std::string> text = PoseLine(frame, line).Text(field);
    const std::optional<double> number = text ? NumberFromText(*text) : std::nullopt;
    if (number) sizes.push_back(std::abs(*number));
  }
  if (sizes.empty()) return {};
  std::sort(sizes.begin(), sizes.end());
  return {sizes[sizes.size() / 2], sizes.back()};
}

// Programs write 0 where they do not know the altitude, and no aircraft flies at 0 all the time.
bool HasAltitudesOfZero(const TableFrame& frame, const Table& table) {
  size_t num_zeros = 0;
  for (const TableLine& line : table.lines) {
    const std::optional<std::string> text = PoseLine(frame, line).Text(PoseField::kAltitude);
    if (!text) continue;
    if (NumberFromText(*text) != 0.0) return false;
    ++num_zeros;
  }
  return num_zeros > 0;
}

void RemoveAngles(PoseColumns& header, const std::string& why) {
  for (const PoseField field :
       {PoseField::kRoll, PoseField::kPitch, PoseField::kYaw, PoseField::kImageUpHeading}) {
    header.columns.erase(field);
  }
  header.warnings.push_back("CameraAnglesIgnored: " + why);
}

// Roll, pitch and yaw are of an aircraft or of a camera that looks down. Programs write other
// angles below the same names.
void CheckAngles(const Table& table, TableFrame& frame) {
  PoseColumns& header = frame.header;
  const Sizes roll = SizesOf(frame, table, PoseField::kRoll);
  const Sizes pitch = SizesOf(frame, table, PoseField::kPitch);
  const auto heading = header.Has(PoseField::kYaw) ? PoseField::kYaw : PoseField::kImageUpHeading;
  const double yaw = SizesOf(frame, table, heading).median;
  const bool is_headless = !table.header;
  const bool is_tilted = roll.median > kMaxTiltDeg ||
                         (is_headless && std::max(roll.largest, pitch.largest) > kMaxTiltDeg);
  // Kappa, in one direction of flight.
  const bool is_kappa =
      is_headless && roll.median > 0.0 && (roll.median > kMaxSteadyRollDeg || yaw <= roll.median);
  if (is_tilted || is_kappa) {
    RemoveAngles(header, "the angles are no yaw, pitch, roll (omega, phi, kappa?)");
  } else if (pitch.median > kMaxTiltDeg && header.Has(PoseField::kYaw)) {
    for (const auto& [from, to] : {std::pair{PoseField::kRoll, PoseField::kGimbalRoll},
                                   {PoseField::kPitch, PoseField::kGimbalPitch},
                                   {PoseField::kYaw, PoseField::kGimbalYaw}}) {
      if (auto column = header.columns.extract(from); !column.empty()) {
        header.columns.insert_or_assign(to, column.mapped());
      }
    }
    header.warnings.emplace_back(
        "the pitches are near 90 degrees: they are read as a gimbal's, where 0 is the horizon");
  }
}

// Three poses that all have the angles 0, 0, 0: nobody measured them.
void FindZeroAngles(const Table& table, TableFrame& frame) {
  PoseColumns& header = frame.header;
  const bool has_all = header.Has(PoseField::kRoll) && header.Has(PoseField::kPitch) &&
                       (header.Has(PoseField::kYaw) || header.Has(PoseField::kImageUpHeading));
  const bool has_gimbal = header.Has(PoseField::kGimbalPitch) && header.Has(PoseField::kGimbalYaw);
  if (!has_all && !has_gimbal) return;
  frame.are_zero_angles_unknown = !table.header;
  for (const PoseField field : kAngleFields) {
    for (const TableLine& line : table.lines) {
      const std::optional<std::string> text = PoseLine(frame, line).Text(field);
      if (text && NumberFromText(*text) != 0.0) return;
    }
  }
  if (!table.header || table.lines.size() < kMinNumZeroAngles) return;
  frame.are_zero_angles_unknown = true;
  header.warnings.emplace_back("all angles are 0: they are taken as not known");
}

// The mean distance of the first lines from the reference; infinite where none is on the earth.
double DistanceDeg(const Table& table, const TableFrame& frame, const GeoPoint& reference) {
  double sum_deg = 0.0;
  size_t num = 0;
  for (const TableLine& line : table.lines) {
    if (num == kNumComparedLines) break;
    try {
      sum_deg += DegreesBetween(PlaceOf(PoseLine(frame, line)).place, reference);
      ++num;
    } catch (const ApiError&) {
      continue;
    }
  }
  return num == 0 ? std::numeric_limits<double>::infinity() : sum_deg / static_cast<double>(num);
}

// x and y stand in either order. The photographs' own tags decide, or which order is on the earth.
void FindOrder(const Table& table, const SideContext& context, TableFrame& frame) {
  if (!frame.header.Has(PoseField::kX)) return;
  std::optional<GeoPoint> reference = context.origin;
  for (const auto& [image_id, tags] : context.image_tags) {
    if (!reference) reference = tags.position;
  }
  constexpr double kFarDeg = 0.2;
  const double as_given_deg = DistanceDeg(table, frame, reference.value_or(GeoPoint{}));
  const bool may_be_wrong = reference ? as_given_deg > kFarDeg : std::isinf(as_given_deg);
  if (may_be_wrong) {
    frame.is_swapped = true;
    const double swapped_deg = DistanceDeg(table, frame, reference.value_or(GeoPoint{}));
    frame.is_swapped = reference ? swapped_deg < kFarDeg : !std::isinf(swapped_deg);
  }
  if (frame.is_system_told && !frame.is_swapped) return;
  const auto name = [&](PoseField field) {
    const auto& column = frame.header.columns.at(field);
    return table.header ? "column \"" + column.name + "\""
                        : "value " + std::to_string(column.index + 1);
  };
  const PoseField x = frame.is_swapped ? PoseField::kY : PoseField::kX;
  const PoseField y = frame.is_swapped ? PoseField::kX : PoseField::kY;
  frame.header.warnings.push_back(name(x) + " is read as the longitude or easting, " + name(y) +
                                  " as the latitude or northing");
}

bool HasDecimalComma(const Table& table, const TableFrame& frame) {
  for (const TableLine& line : table.lines) {
    for (const PoseField field : {PoseField::kLatitude, PoseField::kX}) {
      const std::optional<std::string> text = PoseLine(frame, line).Text(field);
      if (text) return text->find(',') != std::string::npos && text->find('.') == std::string::npos;
    }
  }
  return false;
}

// The columns of a table without a header, from one of its lines: an image and numbers behind. With
// a coordinate system the order is that of OpenDroneMap, without that of Pix4D.
PoseColumns GuessedHeader(const TableLine& line, bool has_coordinate_system) {
  const auto is_name = [](const std::string& cell) { return !NumberFromText(cell); };
  auto image = std::find_if(line.cells.begin(), line.cells.end(), IsImageName);
  if (image == line.cells.end())
    image = std::find_if(line.cells.begin(), line.cells.end(), is_name);
  const size_t first =
      image == line.cells.end() ? 0 : static_cast<size_t>(image - line.cells.begin());
  // Of OpenDroneMap: x y z yaw pitch roll accuracies, where yaw is the heading of the image's top.
  static const std::vector<PoseField> kOfOdm{PoseField::kX,
                                             PoseField::kY,
                                             PoseField::kAltitude,
                                             PoseField::kImageUpHeading,
                                             PoseField::kPitch,
                                             PoseField::kRoll,
                                             PoseField::kPositionSd};
  static const std::vector<PoseField> kOfPix4d{PoseField::kY, PoseField::kX, PoseField::kAltitude};
  PoseColumns header;
  header.columns[PoseField::kImage] = {first, std::string(NameOf(PoseField::kImage)), {}};
  size_t at = first == 0 ? 1 : 0;
  for (const PoseField field : has_coordinate_system ? kOfOdm : kOfPix4d) {
    if (at == first) ++at;
    if (at >= line.cells.size()) break;
    header.columns[field] = {at++, std::string(NameOf(field)), {}};
  }
  if (header.Has(PoseField::kImageUpHeading) && !header.Has(PoseField::kRoll)) {
    for (const PoseField field : {PoseField::kImageUpHeading, PoseField::kPitch})
      header.columns.erase(field);
  }
  if (!header.Has(PoseField::kX) || !header.Has(PoseField::kY)) {
    throw InvalidPose(LinePointer(line.number), "must be: image x y z");
  }
  return header;
}

}  // namespace

TableFrame FrameOf(const Table& table, const SideContext& context) {
  TableFrame frame;
  frame.is_system_told = !table.coordinate_system.empty();
  try {
    frame.system = std::make_unique<CoordinateSystem>(frame.is_system_told ? table.coordinate_system
                                                                           : "epsg:4326");
  } catch (const std::invalid_argument& error) {
    throw InvalidPose("/poses", error.what());
  }
  frame.header =
      table.header ? ReadHeader(table) : GuessedHeader(table.lines.at(0), frame.is_system_told);
  const bool has_placeholders = HasAltitudesOfZero(frame, table);
  if (has_placeholders) frame.header.columns.erase(PoseField::kAltitude);
  for (const auto& [image_id, tags] : context.image_tags) frame.tags.emplace(image_id, tags);
  if (!table.header && !frame.is_system_told) {
    frame.header.warnings.emplace_back(
        "there is no header: image, latitude, longitude and altitude are read, no further column");
  }
  if (frame.header.Has(PoseField::kImageUpHeading) && !table.header) {
    // The format defines its angles poorly.
    constexpr double kOdmAttitudeSdDeg = 5.0;
    frame.header.attitude_sd_deg = kOdmAttitudeSdDeg;
  }
  if (!frame.header.Has(PoseField::kAltitude)) {
    if (frame.tags.empty()) {
      throw InvalidPose(
          LinePointer(table.header ? table.header->number : table.lines[0].number) + "/altitude_m",
          has_placeholders ? "the altitudes are all 0" : "the column altitude_m is needed");
    }
    frame.header.warnings.emplace_back(
        std::string(has_placeholders ? "the altitudes are all 0" : "there is no altitude") +
        ": those of the photographs' own tags are used");
  }
  frame.has_decimal_comma = HasDecimalComma(table, frame);
  FindOrder(table, context, frame);
  CheckAngles(table, frame);
  FindZeroAngles(table, frame);
  if (!table.header && frame.header.attitude_sd_deg && frame.header.Has(PoseField::kRoll)) {
    frame.header.warnings.emplace_back(
        "geo.txt: the angles are taken as yaw, pitch, roll of a nadir camera");
  }
  for (std::string& warning : AssumptionsOf(frame.header)) {
    frame.header.warnings.push_back(std::move(warning));
  }
  return frame;
}

}  // namespace freelsd
