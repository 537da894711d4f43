#include "tests/evaluation/places/place_report.h"

#include <algorithm>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "tests/evaluation/places/place_scores.h"

namespace freelsd {
namespace {

using Json = nlohmann::json;
using Answers = std::vector<PhotographAnswers>;
using Probability = std::optional<double> PolygonAnswer::*;

constexpr uint64_t kBootstrapSeed = 1;
// No later stage corrects an answer that is this sure.
constexpr double kSureProbability = 0.99;
// Far lower or far higher than the photographs of our aircraft.
const std::set<std::string> kOtherScalePlaces{"semantic_drone", "loveda_mmseg"};

bool IsGrass(PlaceClass surface) { return surface == PlaceClass::kGrass; }

bool IsDisputed(const PolygonAnswer& answer) {
  return answer.second_opinion && IsGrass(answer.surface) != IsGrass(*answer.second_opinion);
}

Json FigureOrNull(const Figure& figure) { return figure ? Json(*figure) : Json(); }

Json FigureOrNull(const std::optional<Interval>& interval) {
  return interval ? Json{interval->low, interval->high} : Json();
}

// Whether a class takes part in a figure.
using ClassFilter = bool (*)(PlaceClass);

bool IsAnyClass(PlaceClass /*surface*/) { return true; }

bool IsNotRough(PlaceClass surface) { return surface != PlaceClass::kRoughGrass; }

// What is judged of each photograph: answered and undisputed polygons of the classes.
std::vector<JudgedPolygons> JudgedOf(const Answers& answers,
                                     Probability probability,
                                     ClassFilter counts) {
  std::vector<JudgedPolygons> photographs;
  photographs.reserve(answers.size());
  for (const PhotographAnswers& photograph : answers) {
    JudgedPolygons& judged = photographs.emplace_back();
    for (const PolygonAnswer& answer : photograph.polygons) {
      if (IsDisputed(answer) || !(answer.*probability) || !counts(answer.surface)) continue;
      judged.push_back({*(answer.*probability), IsGrass(answer.surface)});
    }
  }
  return photographs;
}

JudgedPolygons Pooled(const std::vector<JudgedPolygons>& photographs) {
  JudgedPolygons all;
  for (const JudgedPolygons& some : photographs) all.insert(all.end(), some.begin(), some.end());
  return all;
}

double MinGrassProbability() { return ClassificationOptions{}.min_grass_probability; }

const std::vector<std::pair<std::string, Statistic>>& Statistics() {
  static const std::vector<std::pair<std::string, Statistic>> kStatistics{
      {"error", [](const auto& polygons) { return ErrorOf(polygons, MinGrassProbability()); }},
      {"auc", AreaUnderCurveOf},
      {"precision",
       [](const auto& polygons) { return PrecisionOf(polygons, MinGrassProbability()); }},
      {"recall", [](const auto& polygons) { return RecallOf(polygons, MinGrassProbability()); }},
      {"calibration_error", CalibrationErrorOf}};
  return kStatistics;
}

Json ReliabilityJson(const JudgedPolygons& polygons) {
  Json rows = Json::array();
  for (const ReliabilityBin& bin : ReliabilityOf(polygons)) {
    Json row{{"num_polygons", bin.num_polygons}};
    if (bin.num_polygons > 0) {
      row["mean_predicted"] = bin.predicted_sum / bin.num_polygons;
      row["observed_ratio"] = static_cast<double>(bin.num_grass) / bin.num_polygons;
    }
    rows.push_back(row);
  }
  return rows;
}

// For each class: polygons, polygons with an answer, and how many are called grass, surely or not.
Json ByClass(const Answers& answers, Probability probability) {
  Json by_class = Json::object();
  for (const PhotographAnswers& photograph : answers) {
    for (const PolygonAnswer& answer : photograph.polygons) {
      if (IsDisputed(answer)) continue;
      const auto [entry, is_new] = by_class.emplace(
          NameOf(answer.surface),
          Json{{"num_polygons", 0}, {"num_answered", 0}, {"num_called_grass", 0}, {"num_sure", 0}});
      const auto add = [&row = *entry](const char* key, bool is_counted) {
        row[key] = row[key].get<int>() + (is_counted ? 1 : 0);
      };
      const std::optional<double>& given = answer.*probability;
      add("num_polygons", true);
      add("num_answered", given.has_value());
      add("num_called_grass", given && *given >= MinGrassProbability());
      add("num_sure", given && *given >= kSureProbability);
    }
  }
  return by_class;
}

int SumOf(const Json& by_class, const char* key, bool counts_grass) {
  int sum = 0;
  for (const auto& [name, row] : by_class.items()) {
    if (counts_grass || name != NameOf(PlaceClass::kGrass)) sum += row.at(key).get<int>();
  }
  return sum;
}

Json ScoresOf(const Answers& answers, Probability probability) {
  const std::vector<JudgedPolygons> photographs = JudgedOf(answers, probability, IsAnyClass);
  const JudgedPolygons all = Pooled(photographs);
  const Json by_class = ByClass(answers, probability);
  const int num_polygons = SumOf(by_class, "num_polygons", true);
  Json scores{{"num_answered", all.size()}, {"by_class", by_class}};
  scores["no_answer_ratio"] =
      num_polygons > 0 ? Json(1.0 - static_cast<double>(all.size()) / num_polygons) : Json();
  for (const auto& [name, statistic] : Statistics()) {
    scores[name] = FigureOrNull(statistic(all));
    scores["interval"][name] =
        FigureOrNull(BootstrapInterval(photographs, statistic, kBootstrapSeed));
  }
  const JudgedPolygons smooth = Pooled(JudgedOf(answers, probability, IsNotRough));
  scores["without_rough_grass"] = {{"error", FigureOrNull(ErrorOf(smooth, MinGrassProbability()))},
                                   {"auc", FigureOrNull(AreaUnderCurveOf(smooth))}};
  scores["num_sure_false_grass"] = SumOf(by_class, "num_sure", false);
  scores["reliability"] = ReliabilityJson(all);
  return scores;
}

Json RowOf(const Answers& answers) {
  int num_polygons = 0, num_disputed = 0;
  std::set<std::pair<std::string, std::string>> photographs;
  for (const PhotographAnswers& photograph : answers) {
    photographs.emplace(photograph.place, photograph.photograph);
    num_polygons += static_cast<int>(photograph.polygons.size());
    num_disputed += static_cast<int>(
        std::count_if(photograph.polygons.begin(), photograph.polygons.end(), IsDisputed));
  }
  return {
      {"num_photographs", photographs.size()},
      {"num_coarse_photographs",
       std::count_if(answers.begin(), answers.end(), [](const auto& a) { return a.is_coarse; })},
      {"num_polygons", num_polygons - num_disputed},
      {"num_disputed", num_disputed},
      {"by_regions", ScoresOf(answers, &PolygonAnswer::probability)},
      {"as_one_region", ScoresOf(answers, &PolygonAnswer::probability_as_one_region)}};
}

Json RowsOf(const Answers& answers) {
  Answers ours, others;
  std::map<std::string, Answers> by_place;
  for (const PhotographAnswers& photograph : answers) {
    (kOtherScalePlaces.contains(photograph.place) ? others : ours).push_back(photograph);
    by_place[photograph.place].push_back(photograph);
  }
  Json rows{{"pooled", RowOf(ours)}, {"other_scale", RowOf(others)}, {"places", Json::object()}};
  for (const auto& [place, some] : by_place) rows["places"][place] = RowOf(some);
  return rows;
}

// Agreement of the two people, each polygon once.
Json SecondOpinionOf(const Answers& answers) {
  std::set<std::pair<std::string, std::string>> compared;
  int num_differ = 0, num_disputed = 0;
  for (const PhotographAnswers& photograph : answers) {
    for (const PolygonAnswer& answer : photograph.polygons) {
      if (!answer.second_opinion || !compared.emplace(photograph.place, answer.id).second) continue;
      num_differ += *answer.second_opinion != answer.surface ? 1 : 0;
      num_disputed += IsDisputed(answer) ? 1 : 0;
    }
  }
  const auto ratio = [&](int count) {
    return compared.empty() ? Json() : Json(static_cast<double>(count) / compared.size());
  };
  return {{"num_compared", compared.size()},
          {"differ_ratio", ratio(num_differ)},
          {"differ_on_grass_ratio", ratio(num_disputed)}};
}

}  // namespace

Json MakePlaceReport(const Json& settings, Answers answers) {
  const auto key = [](const PhotographAnswers& a) {
    return std::tie(a.place, a.photograph, a.variation);
  };
  std::sort(answers.begin(), answers.end(), [&](const auto& a, const auto& b) {
    return key(a) < key(b);
  });
  std::map<std::string, Answers> by_variation;
  Json photographs = Json::array();
  for (const PhotographAnswers& photograph : answers) {
    by_variation[photograph.variation].push_back(photograph);
    photographs.push_back(ToJson(photograph));
  }
  Json variations = Json::object();
  for (const auto& [variation, some] : by_variation) variations[variation] = RowsOf(some);
  return {{"settings", settings},
          {"second_opinion", SecondOpinionOf(answers)},
          {"variations", variations},
          {"photographs", photographs}};
}

bool IsBetterThanChance(const Json& report) {
  constexpr double kChance = 0.5;
  const Json& variations = report.at("variations");
  return std::all_of(variations.begin(), variations.end(), [](const Json& rows) {
    const Json& auc = rows.at("pooled").at("by_regions").at("auc");
    return auc.is_null() || auc.get<double>() >= kChance;
  });
}

}  // namespace freelsd
