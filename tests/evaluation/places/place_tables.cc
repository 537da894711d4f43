#include <cmath>
#include <iomanip>
#include <sstream>

#include "tests/evaluation/places/place_report.h"

namespace freelsd {
namespace {

using Json = nlohmann::json;

constexpr int kDigits = 3;

std::string Number(const Json& figure, int digits = kDigits) {
  if (figure.is_null()) return "-";
  std::ostringstream text;
  text << std::fixed << std::setprecision(digits) << figure.get<double>();
  return text.str();
}

// A figure with its 95 % interval.
std::string WithInterval(const Json& scores, const char* name) {
  const Json& interval = scores.at("interval").at(name);
  std::string text = Number(scores.at(name));
  if (interval.is_null()) return text;
  return text + " (" + Number(interval.at(0), 2) + " to " + Number(interval.at(1), 2) + ")";
}

int CountOf(const Json& scores, const char* surface, const char* key) {
  const Json& by_class = scores.at("by_class");
  return by_class.contains(surface) ? by_class.at(surface).at(key).get<int>() : 0;
}

std::string ScoresRow(const std::string& name, const Json& row, const char* kind) {
  const Json& scores = row.at(kind);
  std::ostringstream out;
  const bool is_coarse = row.at("num_coarse_photographs") > 0;
  out << "| " << name << (is_coarse ? " (coarse)" : "") << " | " << row.at("num_photographs")
      << " | " << row.at("num_polygons") << " | " << CountOf(scores, "grass", "num_polygons")
      << " | " << CountOf(scores, "rough_grass", "num_polygons") << " | "
      << Number(scores.at("no_answer_ratio"), 2) << " | " << WithInterval(scores, "error") << " | "
      << WithInterval(scores, "auc") << " | " << WithInterval(scores, "precision") << " | "
      << WithInterval(scores, "recall") << " | " << WithInterval(scores, "calibration_error")
      << " | " << scores.at("num_sure_false_grass") << " |\n";
  return out.str();
}

std::string ScoresTable(const Json& rows, const char* kind) {
  std::ostringstream out;
  out << "| place | photographs | polygons | grass | rough grass | no answer | error | AUC | "
         "precision | recall | ECE | not grass at p >= 0.99 |\n"
         "|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const auto& [place, row] : rows.at("places").items()) out << ScoresRow(place, row, kind);
  out << ScoresRow("**pooled**", rows.at("pooled"), kind)
      << ScoresRow("**other scale**", rows.at("other_scale"), kind);
  return out.str();
}

std::string ReliabilityTable(const Json& row) {
  std::ostringstream out;
  out << "| predicted | polygons | mean predicted | observed | as one region: polygons | mean "
         "predicted | observed |\n|---|---|---|---|---|---|---|\n";
  const Json& by_regions = row.at("by_regions").at("reliability");
  const Json& as_one = row.at("as_one_region").at("reliability");
  for (size_t bin = 0; bin < by_regions.size(); ++bin) {
    out << "| " << Number(0.1 * static_cast<double>(bin), 1) << " to "
        << Number(0.1 * static_cast<double>(bin + 1), 1);
    for (const Json* bins : {&by_regions, &as_one}) {
      const Json& entry = bins->at(bin);
      out << " | " << entry.at("num_polygons") << " | "
          << Number(entry.value("mean_predicted", Json()), 2) << " | "
          << Number(entry.value("observed_ratio", Json()), 2);
    }
    out << " |\n";
  }
  return out.str();
}

std::string ClassTable(const Json& row) {
  std::ostringstream out;
  out << "| class | polygons | answered | called grass | p >= 0.99 | as one region: called grass | "
         "p >= 0.99 |\n|---|---|---|---|---|---|---|\n";
  const Json& as_one = row.at("as_one_region");
  for (const auto& [surface, counts] : row.at("by_regions").at("by_class").items()) {
    out << "| " << surface << " | " << counts.at("num_polygons") << " | "
        << counts.at("num_answered") << " | " << counts.at("num_called_grass") << " | "
        << counts.at("num_sure") << " | " << CountOf(as_one, surface.c_str(), "num_called_grass")
        << " | " << CountOf(as_one, surface.c_str(), "num_sure") << " |\n";
  }
  return out.str();
}

// Without rough grass, which people disagree about most.
std::string SmoothLine(const Json& row) {
  const Json& by_regions = row.at("by_regions").at("without_rough_grass");
  const Json& as_one = row.at("as_one_region").at("without_rough_grass");
  return "Without rough grass: error " + Number(by_regions.at("error")) + ", AUC " +
         Number(by_regions.at("auc")) + "; as one region " + Number(as_one.at("error")) + ", " +
         Number(as_one.at("auc")) + ".\n";
}

std::string VariationText(const std::string& variation, const Json& rows) {
  std::ostringstream out;
  out << "## Variation " << variation << "\n\nBy regions:\n\n"
      << ScoresTable(rows, "by_regions") << "\nEach polygon as one region:\n\n"
      << ScoresTable(rows, "as_one_region");
  for (const char* pool : {"pooled", "other_scale"}) {
    const Json& row = rows.at(pool);
    if (row.at("num_polygons").get<int>() == 0) continue;
    out << "\n### Classes and calibration, "
        << (std::string(pool) == "pooled" ? pool : "other scale") << "\n\n"
        << SmoothLine(row) << "\n"
        << ClassTable(row) << "\n"
        << ReliabilityTable(row);
  }
  return out.str();
}

std::string RobustnessTable(const Json& variations) {
  std::ostringstream out;
  out << "## Robustness, pooled\n\n| variation | no answer | error | AUC | ECE | as one region: "
         "error | AUC | ECE |\n|---|---|---|---|---|---|---|---|\n";
  for (const auto& [variation, rows] : variations.items()) {
    const Json& scores = rows.at("pooled").at("by_regions");
    const Json& as_one = rows.at("pooled").at("as_one_region");
    out << "| " << variation << " | " << Number(scores.at("no_answer_ratio"), 2);
    for (const Json* figures : {&scores, &as_one}) {
      for (const char* name : {"error", "auc", "calibration_error"}) {
        out << " | " << WithInterval(*figures, name);
      }
    }
    out << " |\n";
  }
  return out.str();
}

std::string SecondOpinionLine(const Json& opinion) {
  return "Second opinion: " + opinion.at("num_compared").dump() +
         " polygons compared, the classes " + "differ on " + Number(opinion.at("differ_ratio")) +
         ", grass or not grass on " + Number(opinion.at("differ_on_grass_ratio")) +
         ". The latter count for nothing.\n";
}

}  // namespace

std::string PlaceReportAsMarkdown(const Json& report) {
  std::ostringstream out;
  for (const auto& [variation, rows] : report.at("variations").items()) {
    out << VariationText(variation, rows) << "\n";
  }
  out << RobustnessTable(report.at("variations")) << "\n"
      << SecondOpinionLine(report.at("second_opinion"));
  return out.str();
}

}  // namespace freelsd
