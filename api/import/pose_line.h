// Private to import/. One line of a pose file.
#pragma once

#include <optional>
#include <string>

#include "api/import/csv.h"
#include "api/import/import.h"
#include "api/import/pose_columns.h"

namespace freelsd {

// ApiError InvalidPoses with one error.
ApiError InvalidPose(const std::string& pointer, const std::string& detail);
// "/poses/<line>".
std::string LinePointer(int line);

// One line of a CSV, cell by cell; the header and the line must outlive it.
class PoseLine {
 public:
  PoseLine(const PoseColumns& header, const CsvLine& line) : header_(header), line_(line) {}

  // Of the cell, by the file's own name of the column.
  std::string Pointer(PoseField field) const;
  // Empty cells are unknown.
  std::optional<std::string> Text(PoseField field) const;
  // Both throw ApiError InvalidPoses at the cell.
  std::optional<double> Number(PoseField field) const;
  std::optional<double> AngleRad(PoseField field) const;

  int number() const { return line_.number; }
  const PoseColumns& header() const { return header_; }

 private:
  const PoseColumns& header_;
  const CsvLine& line_;
};

// What the line says of its frame. Throws ApiError InvalidPoses at the cell that cannot be used.
FrameMeta ReadPoseLine(const PoseLine& line);

}  // namespace freelsd
