// Stored strips and photographed passes as files: photographs cost most, and a method that changes
// needs no new ones.
#pragma once

#include <string>
#include <vector>

#include "tests/evaluation/watch/second_pass.h"

namespace freelsd {

struct RecordedPass {
  // World and pass, "2003-7".
  std::string name;
  // File of the strip, in the same folder.
  std::string strip_file;
  PassPlan plan;
  std::vector<PassPhoto> photos;
};

// The files are read by the machine and the build that wrote them. Reading throws
// std::runtime_error on a file that cannot be read or that ends early.
void WriteStrip(const StripPicture& strip, const std::string& file);
StripPicture ReadStrip(const std::string& file);
void WritePass(const RecordedPass& pass, const std::string& file);
RecordedPass ReadPass(const std::string& file);

// Of passes, in the order of their names.
std::vector<std::string> PassFilesIn(const std::string& folder);

}  // namespace freelsd
