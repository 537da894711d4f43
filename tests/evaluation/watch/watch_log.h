// What the watch said of each photograph of a pass, as rows of a file, and the figures of them.
#pragma once

#include <string>
#include <vector>

#include "engine/watch/watch.h"
#include "tests/evaluation/watch/second_pass.h"

namespace freelsd {

struct WatchRow {
  // World or flight, strip and pass: photographs of one pass over one strip share it.
  std::string pass;
  std::string event;
  std::string change;
  double height_m = 0.0;
  double tilt_deg = 0.0;
  int number = 0;
  LookResult result = LookResult::kNotShown;
  StripStatus status = StripStatus::kUnknown;
  double compared_ratio = 0.0;
  double correlation = 0.0;
  int num_things = 0;
  double deviations = 0.0;
  // New things that stand on the strip; those that the look found; whether the report has one.
  int num_shown = 0;
  int num_found = 0;
  bool is_told = false;
};

// Adds rows at the end.
void WriteRows(const std::vector<WatchRow>& rows, const std::string& file);
std::vector<WatchRow> ReadRows(const std::string& file);

// Tables in Markdown: events told, by kind; false alarms, by what was different.
std::string WatchReport(const std::vector<WatchRow>& rows);

}  // namespace freelsd
