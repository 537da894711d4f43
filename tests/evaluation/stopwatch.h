// Where the time of one world goes: processor seconds by part.
#pragma once

#include <map>
#include <string>

namespace freelsd {

class Stopwatch {
 public:
  // Counts the calling thread alone, or the whole process where other threads work for it.
  explicit Stopwatch(bool counts_process);

  // What was spent since the last lap belongs to that part; parts may be named again and again.
  void Lap(const std::string& part);
  const std::map<std::string, double>& seconds() const { return seconds_; }

 private:
  double Now() const;

  bool counts_process_;
  double last_;
  std::map<std::string, double> seconds_;
};

}  // namespace freelsd
