// Reads one line of a table of poses. Private to poses/.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "api/import/import.h"
#include "api/import/poses/coordinate_system.h"
#include "api/import/poses/pose_columns.h"
#include "api/import/poses/poses.h"

namespace freelsd {

// Makes an ApiError InvalidPoses with one entry in `errors`.
ApiError InvalidPose(const std::string& pointer, const std::string& detail);
// "/poses/<line>".
std::string LinePointer(int line);

// What is common to all lines of a table.
struct TableFrame {
  PoseColumns header;
  // Numbers have a decimal comma.
  bool has_decimal_comma = false;
  // Of x and y. Longitude and latitude where the file names none.
  std::unique_ptr<const CoordinateSystem> system;
  bool is_system_told = false;
  // x and y are the other way round.
  bool is_swapped = false;
  // Angles of 0, 0, 0 are not known.
  bool are_zero_angles_unknown = false;
  // Positions of the photographs' own tags, by frame id. They give the altitude that a line lacks.
  std::map<std::string, FrameMeta> tags;
};

// Finds the columns and, where names leave it open, the order of x and y and the convention of
// angles. Throws ApiError InvalidPoses.
TableFrame FrameOf(const Table& table, const SideContext& context);

// Cells of one line by field. The frame and the line must outlive this object. What cannot be read
// throws ApiError InvalidPoses with a pointer to the cell; the pointer contains the column's name
// as written in the file.
class PoseLine {
 public:
  PoseLine(const TableFrame& frame, const TableLine& line) : frame_(frame), line_(line) {}

  std::string Pointer(PoseField field) const;
  // Nothing if the cell is empty.
  std::optional<std::string> Text(PoseField field) const;
  // In metres, metres per second or degrees. Nothing if the cell is empty.
  std::optional<double> Number(PoseField field) const;
  std::optional<double> AngleRad(PoseField field) const;
  // Of a latitude or longitude, with its hemisphere.
  std::optional<double> Coordinate(PoseField field) const;
  // Microseconds since 1970.
  std::optional<int64_t> Time() const;

  int number() const { return line_.number; }
  const TableFrame& frame() const { return frame_; }
  const PoseColumns& header() const { return frame_.header; }

 private:
  const TableFrame& frame_;
  const TableLine& line_;
};

// Metadata of the line's frame. Throws ApiError InvalidPoses if the line has no usable image or
// place. Any other value that cannot be used is left out, and `leave_out` is told why.
using LeaveOut = std::function<void(const ApiError&)>;
FrameMeta ReadPoseLine(const PoseLine& line, const LeaveOut& leave_out);

// Place of a line, with its altitude, and the altitude's datum. Throws as above.
struct LinePlace {
  GeoPoint place;
  std::optional<std::string> altitude_datum;
};
LinePlace PlaceOf(const PoseLine& line);

}  // namespace freelsd
