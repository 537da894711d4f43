// Private to import/. Reads one line of a pose file.
#pragma once

#include <optional>
#include <string>

#include "api/import/import.h"
#include "api/import/poses/csv.h"
#include "api/import/poses/pose_columns.h"
#include "api/import/poses/poses.h"

namespace freelsd {

// Makes an ApiError InvalidPoses with one entry in `errors`.
ApiError InvalidPose(const std::string& pointer, const std::string& detail);
// "/poses/<line>".
std::string LinePointer(int line);

// Cells of one CSV line by field. The header and the line must outlive this object.
class PoseLine {
 public:
  PoseLine(const PoseColumns& header, const CsvLine& line) : header_(header), line_(line) {}

  // JSON pointer to the cell. It contains the column's name as written in the file.
  std::string Pointer(PoseField field) const;
  // Nothing if the cell is empty.
  std::optional<std::string> Text(PoseField field) const;
  // Nothing if the cell is empty. Number and AngleRad throw ApiError InvalidPoses with a pointer to
  // the cell.
  std::optional<double> Number(PoseField field) const;
  std::optional<double> AngleRad(PoseField field) const;

  int number() const { return line_.number; }
  const PoseColumns& header() const { return header_; }

 private:
  const PoseColumns& header_;
  const CsvLine& line_;
};

// Metadata of the line's frame. Throws ApiError InvalidPoses with a pointer to the invalid cell.
FrameMeta ReadPoseLine(const PoseLine& line);

}  // namespace freelsd
