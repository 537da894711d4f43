// An aid for labelling by eye: photographs with their regions outlined and numbered, and a table of
// the regions whose column `class` is to be filled in.
#pragma once

#include <string>

#include "server/labelled_photographs.h"

namespace freelsd {

// Columns of a table of labelled regions, FLIGHT.csv: photograph (file name), region (number on the
// sheet), class (as in masks; 0: not labelled, or of several surfaces), rings: x and y in pixels of
// the photograph, separated by spaces; rings, the holes among them, separated by '|'.
constexpr const char* kLabelTableHeader = "photograph,region,class,rings";

// The table of one photograph's regions, all of class 0.
std::string RegionRows(const LabelledPhotograph& photograph, const Segments& segments);

// The photograph, width_px wide, with its regions outlined: in red, or where `labels` has one per
// region in green for grass, yellow for unsure and red for the rest.
cv::Mat3b RegionSheet(const LabelledPhotograph& photograph,
                      const Segments& segments,
                      const Labels& labels,
                      int width_px);

}  // namespace freelsd
