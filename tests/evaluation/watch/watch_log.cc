#include "tests/evaluation/watch/watch_log.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>

namespace freelsd {
namespace {

constexpr const char* kHeader =
    "pass,event,change,height_m,tilt_deg,number,result,status,compared_ratio,correlation,num_"
    "things,"
    "deviations,num_shown,num_found,is_told";
constexpr size_t kNumColumns = 15;

std::string Line(const char* format, ...) {
  char text[512];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  return text;
}

struct PassSummary {
  std::string event, change;
  double height_m = 0.0, tilt_deg = 0.0;
  int num_photos = 0, num_compared = 0;
  // Photographs that show the event, and how many had been taken when it was told; 0 if never.
  int num_showing = 0, told_with = 0;
  // Of those, within the first two.
  int num_early_compared = 0;
  bool is_alarmed = false;
};

std::vector<PassSummary> Summaries(const std::vector<WatchRow>& rows) {
  std::vector<PassSummary> passes;
  std::string last;
  for (const WatchRow& row : rows) {
    if (passes.empty() || row.pass != last) {
      passes.push_back({row.event, row.change, row.height_m, row.tilt_deg});
    }
    last = row.pass;
    PassSummary& pass = passes.back();
    ++pass.num_photos;
    pass.num_compared += row.result == LookResult::kCompared;
    pass.num_showing += row.num_shown > 0;
    if (row.num_shown > 0 && pass.num_showing <= kNumPhotosInTime) {
      pass.num_early_compared += row.result == LookResult::kCompared;
    }
    if (row.is_told && pass.told_with == 0) pass.told_with = std::max(1, pass.num_showing);
    pass.is_alarmed = pass.is_alarmed || row.status == StripStatus::kOccupied;
  }
  return passes;
}

struct EventCount {
  int all = 0, in_time = 0, late = 0, unknown = 0;

  void Add(const PassSummary& pass) {
    ++all;
    if (pass.told_with > 0 && pass.told_with <= kNumPhotosInTime) {
      ++in_time;
    } else if (pass.told_with > 0) {
      ++late;
    }
    if (pass.told_with == 0 && pass.num_early_compared < kNumPhotosInTime) ++unknown;
  }
};

// 95 % interval of a ratio (Wilson).
std::array<double, 2> Interval(int part, int whole) {
  if (whole == 0) return {0.0, 1.0};
  constexpr double kZ = 1.96;
  const double n = whole, p = part / n, z2 = kZ * kZ;
  const double middle = (p + z2 / (2 * n)) / (1 + z2 / n);
  const double half = kZ / (1 + z2 / n) * std::sqrt(p * (1 - p) / n + z2 / (4 * n * n));
  return {std::max(0.0, middle - half), std::min(1.0, middle + half)};
}

double PoissonUpTo(int count, double mean) {
  double term = std::exp(-mean), sum = term;
  for (int k = 1; k <= count; ++k) sum += term *= mean / k;
  return sum;
}

// Exact 95 % interval of the mean of a Poisson distribution.
std::array<double, 2> PoissonInterval(int count) {
  const auto solve = [](auto probability_of, double target) {
    double low = 0.0, high = 1000.0;
    for (int i = 0; i < 80; ++i) {
      const double middle = 0.5 * (low + high);
      (probability_of(middle) > target ? low : high) = middle;
    }
    return low;
  };
  const double low =
      count == 0 ? 0.0 : solve([&](double mean) { return PoissonUpTo(count - 1, mean); }, 0.975);
  return {low, solve([&](double mean) { return PoissonUpTo(count, mean); }, 0.025)};
}

std::string EventTable(const char* title, const std::map<std::string, EventCount>& counts) {
  std::string text = Line(
      "\n| %s | events | told within two photographs | 95 %% interval | later | never, and one of "
      "the first two not compared |\n|---|---|---|---|---|---|\n",
      title);
  for (const auto& [name, count] : counts) {
    const auto range = Interval(count.in_time, count.all);
    text += Line("| %s | %d | %d (%.1f %%) | %.1f to %.1f %% | %d | %d |\n",
                 name.c_str(),
                 count.all,
                 count.in_time,
                 100.0 * count.in_time / std::max(1, count.all),
                 100.0 * range[0],
                 100.0 * range[1],
                 count.late,
                 count.unknown);
  }
  return text;
}

struct QuietCount {
  int passes = 0, photos = 0, compared = 0, alarms = 0;

  void Add(const PassSummary& pass) {
    ++passes;
    photos += pass.num_photos;
    compared += pass.num_compared;
    alarms += pass.is_alarmed;
  }
};

std::string QuietTable(const char* title, const std::map<std::string, QuietCount>& counts) {
  std::string text = Line(
      "\n| %s | passes | photographs | compared | false alarms | an hour of photographs | 95 %% "
      "interval |\n|---|---|---|---|---|---|---|\n",
      title);
  constexpr double kPhotosPerHour = 3600.0;
  for (const auto& [name, count] : counts) {
    const auto range = PoissonInterval(count.alarms);
    const double hours = std::max(1, count.photos) / kPhotosPerHour;
    text += Line("| %s | %d | %d | %d (%.0f %%) | %d | %.2f | %.2f to %.2f |\n",
                 name.c_str(),
                 count.passes,
                 count.photos,
                 count.compared,
                 100.0 * count.compared / std::max(1, count.photos),
                 count.alarms,
                 count.alarms / hours,
                 range[0] / hours,
                 range[1] / hours);
  }
  return text;
}

}  // namespace

void WriteRows(const std::vector<WatchRow>& rows, const std::string& file) {
  const bool is_new = !std::ifstream(file).good();
  std::ofstream out(file, std::ios::app);
  if (is_new) out << kHeader << '\n';
  for (const WatchRow& row : rows) {
    out << row.pass << ',' << row.event << ',' << row.change << ',' << row.height_m << ','
        << row.tilt_deg << ',' << row.number << ',' << static_cast<int>(row.result) << ','
        << static_cast<int>(row.status) << ',' << row.compared_ratio << ',' << row.correlation
        << ',' << row.num_things << ',' << row.deviations << ',' << row.num_shown << ','
        << row.num_found << ',' << row.is_told << '\n';
  }
}

std::vector<WatchRow> ReadRows(const std::string& file) {
  std::ifstream in(file);
  if (!in) throw std::runtime_error("cannot read " + file);
  std::vector<WatchRow> rows;
  std::string line;
  std::getline(in, line);
  if (line != kHeader) throw std::runtime_error(file + ": not a log of freelsd-watch");
  while (std::getline(in, line)) {
    std::vector<std::string> cells;
    std::istringstream parts(line);
    for (std::string cell; std::getline(parts, cell, ',');) cells.push_back(cell);
    if (cells.size() != kNumColumns) throw std::runtime_error(file + ": bad line " + line);
    WatchRow row;
    row.pass = cells[0], row.event = cells[1], row.change = cells[2];
    row.height_m = std::stod(cells[3]), row.tilt_deg = std::stod(cells[4]);
    row.number = std::stoi(cells[5]);
    row.result = static_cast<LookResult>(std::stoi(cells[6]));
    row.status = static_cast<StripStatus>(std::stoi(cells[7]));
    row.compared_ratio = std::stod(cells[8]), row.correlation = std::stod(cells[9]);
    row.num_things = std::stoi(cells[10]), row.deviations = std::stod(cells[11]);
    row.num_shown = std::stoi(cells[12]), row.num_found = std::stoi(cells[13]);
    row.is_told = cells[14] == "1";
    rows.push_back(row);
  }
  return rows;
}

std::string WatchReport(const std::vector<WatchRow>& rows) {
  std::map<std::string, EventCount> by_kind, by_height, by_change;
  std::map<std::string, QuietCount> quiet;
  int num_short = 0;
  for (const PassSummary& pass : Summaries(rows)) {
    if (pass.event == NameOf(WatchEvent::kNone)) {
      quiet[pass.change].Add(pass);
      quiet["~ all"].Add(pass);
      continue;
    }
    if (pass.num_showing < kNumPhotosInTime) {
      ++num_short;
      continue;
    }
    by_kind[pass.event].Add(pass);
    by_kind["~ all"].Add(pass);
    by_height[Line("%.0f m%s", pass.height_m, pass.tilt_deg > 0.0 ? ", looking ahead" : "")].Add(
        pass);
    by_change[pass.change].Add(pass);
  }
  std::string text;
  if (!by_kind.empty()) {
    text += EventTable("event", by_kind) + EventTable("height", by_height) +
            EventTable("different light", by_change);
    text += Line("\nPasses with fewer than two photographs of the event, not counted: %d.\n",
                 num_short);
  }
  if (!quiet.empty()) text += QuietTable("no event", quiet);
  return text;
}

}  // namespace freelsd
