#include "tests/evaluation/frames/comparison.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

namespace freelsd {
namespace {

using Json = nlohmann::json;

constexpr double kLowShare = 0.05;
constexpr double kHighShare = 0.95;
// Beside a narrower spread, any difference would look large.
constexpr double kLeastWidth = 0.01;

double Rounded(double value) {
  constexpr double kScale = 1e4;
  return std::round(value * kScale) / kScale;
}

std::vector<double> Column(const std::vector<Measures>& rows, size_t measure) {
  std::vector<double> values;
  values.reserve(rows.size());
  for (const Measures& row : rows) values.push_back(row[measure]);
  return values;
}

Json SpreadAsJson(const Spread& spread) {
  return {{"low", Rounded(spread.low)},
          {"median", Rounded(spread.median)},
          {"high", Rounded(spread.high)}};
}

// One measure of all looks.
Json CompareMeasure(const std::map<std::string, LookTiles>& looks, size_t measure) {
  const auto recorded = looks.find(kRecorded);
  Json compared;
  for (const auto& [look, tiles] : looks) {
    const Spread spread = SpreadOf(Column(tiles.measures, measure));
    compared[look] = SpreadAsJson(spread);
    const bool is_judged =
        look != kRecorded && recorded != looks.end() &&
        std::min(tiles.measures.size(), recorded->second.measures.size()) >= kMinNumTiles;
    if (!is_judged) continue;
    const Spread truth = SpreadOf(Column(recorded->second.measures, measure));
    compared[look]["distance_outside"] = Rounded(DistanceOutside(spread.median, truth));
  }
  return compared;
}

std::string Text(double value) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(std::abs(value) >= 10.0 ? 0 : 3) << value;
  return text.str();
}

bool IsFlagged(const Json& spread) {
  return spread.contains("distance_outside") && spread["distance_outside"].get<double>() > 0.0;
}

// "0.010 / 0.020 / 0.030", the median bold and marked where it is flagged.
std::string Cell(const Json& spreads, const std::string& look) {
  if (!spreads.contains(look)) return "-";
  const Json& spread = spreads.at(look);
  std::string median = Text(spread.at("median").get<double>());
  if (IsFlagged(spread)) median = "**" + median + " !**";
  return Text(spread.at("low").get<double>()) + " / " + median + " / " +
         Text(spread.at("high").get<double>());
}

std::vector<std::string> LooksOf(const Json& covers) {
  std::vector<std::string> looks{kRecorded};
  for (const auto& [cover, compared] : covers.items()) {
    for (const auto& [look, counts] : compared.at("tiles").items()) {
      if (std::find(looks.begin(), looks.end(), look) == looks.end()) looks.push_back(look);
    }
  }
  std::sort(looks.begin() + 1, looks.end());
  return looks;
}

std::string TableOf(const std::string& cover,
                    const Json& compared,
                    const std::vector<std::string>& looks) {
  std::ostringstream out;
  out << "\n## " << cover << "\n\n| 5 / 50 / 95 % |";
  for (const std::string& look : looks) out << " " << look << " |";
  out << "\n|---|";
  for (size_t i = 0; i < looks.size(); ++i) out << "---|";
  out << "\n| tiles (pictures) |";
  for (const std::string& look : looks) {
    const Json& counts = compared.at("tiles");
    if (!counts.contains(look)) {
      out << " - |";
      continue;
    }
    out << " " << counts.at(look).at("num_tiles") << " (" << counts.at(look).at("num_pictures")
        << ") |";
  }
  out << "\n";
  for (const std::string& measure : MeasureNames()) {
    out << "| " << measure << " |";
    for (const std::string& look : looks) {
      out << " " << Cell(compared.at("measures").at(measure), look) << " |";
    }
    out << "\n";
  }
  return out.str();
}

struct Flag {
  double distance = 0.0;
  std::string text;
};

std::vector<Flag> FlagsOf(const Json& covers) {
  std::vector<Flag> flags;
  for (const auto& [cover, compared] : covers.items()) {
    for (const auto& [measure, spreads] : compared.at("measures").items()) {
      for (const auto& [look, spread] : spreads.items()) {
        if (!IsFlagged(spread)) continue;
        flags.push_back({spread.at("distance_outside").get<double>(),
                         "| " + cover + " | " + measure + " | " + look + " | "});
      }
    }
  }
  std::stable_sort(flags.begin(), flags.end(), [](const Flag& a, const Flag& b) {
    return a.distance > b.distance;
  });
  return flags;
}

}  // namespace

double Quantile(std::vector<double> values, double share) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(values.begin(), values.end());
  const double place = share * static_cast<double>(values.size() - 1);
  const auto lower = static_cast<size_t>(place);
  const size_t upper = std::min(lower + 1, values.size() - 1);
  return values[lower] + (place - static_cast<double>(lower)) * (values[upper] - values[lower]);
}

Spread SpreadOf(const std::vector<double>& values) {
  return {Quantile(values, kLowShare), Quantile(values, 0.5), Quantile(values, kHighShare)};
}

double DistanceOutside(double median, const Spread& recorded) {
  const double excess = std::max(recorded.low - median, median - recorded.high);
  return excess <= 0.0 ? 0.0 : excess / std::max(recorded.high - recorded.low, kLeastWidth);
}

Json CompareLooks(const TilesOfLooks& tiles) {
  Json covers = Json::object();
  for (const auto& [cover, looks] : tiles) {
    Json& compared = covers[CoverName(cover)];
    for (const auto& [look, counted] : looks) {
      compared["tiles"][look] = {{"num_tiles", counted.measures.size()},
                                 {"num_pictures", counted.num_pictures}};
    }
    for (size_t i = 0; i < kNumMeasures; ++i) {
      compared["measures"][MeasureNames()[i]] = CompareMeasure(looks, i);
    }
  }
  return covers;
}

std::string ComparisonAsMarkdown(const Json& report) {
  const Json& covers = report.at("covers");
  const std::vector<std::string> looks = LooksOf(covers);
  std::ostringstream out;
  out << "# Frames beside photographs, pool " << report.at("pool").get<std::string>() << "\n\n"
      << "Tiles of " << report.at("tile_m") << " m at " << report.at("ground_sampling_m")
      << " m per pixel. Bold and `!`: the median lies outside of the recorded 5 to 95 %.\n";
  for (const auto& [cover, compared] : covers.items()) out << TableOf(cover, compared, looks);
  out << "\n## Flags\n\n| cover | measure | world | widths outside |\n|---|---|---|---|\n";
  for (const Flag& flag : FlagsOf(covers)) out << flag.text << Text(flag.distance) << " |\n";
  return out.str();
}

}  // namespace freelsd
