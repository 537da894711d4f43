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

// No later stage corrects an answer that is this sure.
constexpr double kSureProbability = 0.99;
// Far lower or far higher than the photographs of our aircraft.
const std::set<std::string> kOtherScalePlaces{"semantic_drone", "loveda_mmseg"};

bool IsGrass(PlaceClass surface) { return surface == PlaceClass::kGrass; }

bool IsDisputed(const PolygonAnswer& answer) {
  return answer.second_opinion && IsGrass(answer.surface) != IsGrass(*answer.second_opinion);
}

Json FigureOrNull(const Figure& figure) { return figure ? Json(*figure) : Json(); }

// What is judged: answered and undisputed polygons.
JudgedPolygons JudgedOf(const Answers& answers) {
  JudgedPolygons judged;
  for (const PhotographAnswers& photograph : answers) {
    for (const PolygonAnswer& answer : photograph.polygons) {
      if (IsDisputed(answer) || !answer.probability) continue;
      judged.push_back({*answer.probability, IsGrass(answer.surface)});
    }
  }
  return judged;
}

double MinGrassProbability() { return ClassificationOptions{}.min_grass_probability; }

// For each class: polygons, polygons with an answer, and how many are called grass, surely or not.
Json ByClass(const Answers& answers) {
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
      const std::optional<double>& given = answer.probability;
      add("num_polygons", true);
      add("num_answered", given.has_value());
      add("num_called_grass", given && *given >= MinGrassProbability());
      add("num_sure", given && *given >= kSureProbability);
    }
  }
  return by_class;
}

Json RowOf(const Answers& answers) {
  int num_polygons = 0, num_disputed = 0, num_sure = 0;
  for (const PhotographAnswers& photograph : answers) {
    num_polygons += static_cast<int>(photograph.polygons.size());
    num_disputed += static_cast<int>(
        std::count_if(photograph.polygons.begin(), photograph.polygons.end(), IsDisputed));
  }
  const JudgedPolygons judged = JudgedOf(answers);
  const Json by_class = ByClass(answers);
  for (const auto& [name, row] : by_class.items()) {
    if (name != NameOf(PlaceClass::kGrass)) num_sure += row.at("num_sure").get<int>();
  }
  return {{"num_photographs", answers.size()},
          {"num_polygons", num_polygons - num_disputed},
          {"num_disputed", num_disputed},
          {"num_answered", judged.size()},
          {"error", FigureOrNull(ErrorOf(judged, MinGrassProbability()))},
          {"auc", FigureOrNull(AreaUnderCurveOf(judged))},
          {"calibration_error", FigureOrNull(CalibrationErrorOf(judged))},
          {"num_sure_false_grass", num_sure},
          {"by_class", by_class}};
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

Json MakePlaceReport(Answers answers) {
  std::sort(answers.begin(), answers.end(), [](const auto& a, const auto& b) {
    return std::tie(a.place, a.photograph) < std::tie(b.place, b.photograph);
  });
  Json report = RowsOf(answers);
  report["second_opinion"] = SecondOpinionOf(answers);
  report["photographs"] = Json::array();
  for (const PhotographAnswers& photograph : answers) {
    report["photographs"].push_back(ToJson(photograph));
  }
  return report;
}

bool IsBetterThanChance(const Json& report) {
  constexpr double kChance = 0.5;
  const Json& auc = report.at("pooled").at("auc");
  return auc.is_null() || auc.get<double>() >= kChance;
}

}  // namespace freelsd
