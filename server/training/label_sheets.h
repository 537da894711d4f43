// Sheets for labelling by eye: photographs with outlined, numbered regions, and a table of the
// regions. A person fills in its column `class`.
#pragma once

#include <string>

#include "server/training/labelled_photographs.h"

namespace freelsd {

// Columns of a table of labelled regions, FLIGHT.csv.
// photograph: file name. region: number on the sheet. class: as in masks; 0 for regions that are
// not labelled or have several surfaces. rings: outline and holes, separated by '|'; each ring
// lists x and y in pixels of the photograph, separated by spaces.
constexpr const char* kLabelTableHeader = "photograph,region,class,rings";

// The rows of one photograph's regions, all with class 0.
std::string RegionRows(const LabelledPhotograph& photograph, const Segments& segments);

// The photograph with regions outlined in red, width_px wide.
cv::Mat3b RegionSheet(const LabelledPhotograph& photograph, const Segments& segments, int width_px);

}  // namespace freelsd
