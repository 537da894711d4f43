// One stage of the engine against the plain way of doing the same with the libraries at hand.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace freelsd {

struct Contest {
  std::string name;
  // What is worked on: image size, number of points, cells.
  std::string size;
  std::function<void()> engine;
  // Empty where no library does the same.
  std::string baseline;
  std::function<void()> plain;
  // What one run holds of the unit that is reported: frames, pairs.
  double num_units = 1.0;
  // How good the answers of both are, where that is not the same.
  std::string note = {};
};

// A contest by name; what it works on is made only when it is wanted.
struct Entry {
  std::string name;
  std::function<Contest()> prepare;
};

// Medians. Of two clocks: what passed, and what the processors worked for it, which other programs
// on the same machine hardly disturb.
struct Times {
  double wall_ms = 0.0;
  double processor_ms = 0.0;
};

struct Row {
  std::string name;
  std::string size;
  int threads = 1;
  Times engine;
  std::string baseline;
  Times plain;
  std::string note;
};

// Median of `num_runs` of each, in turns, so that both meet the same machine; one run of each
// before, to warm up.
Row Measure(const Contest& contest, int num_runs, int threads);

// Keeps the compiler from leaving out what is measured.
void Consume(double value);

std::vector<Entry> FrontendEntries(const std::string& model_file);
std::vector<Entry> ReconstructionEntries(const std::string& model_file);
std::vector<Entry> MapEntries();
std::vector<Entry> ReachEntries();
std::vector<Entry> KernelEntries(const std::string& model_file);

}  // namespace freelsd
