#include <cmath>
#include <filesystem>
#include <limits>

#include <doctest/doctest.h>

#include "tests/evaluation/kinds/kind_scores.h"

namespace freelsd {
namespace {

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

// Grass where a cue is between 1 and 2, in three places; another cue is the place's number alone.
KindCells CellsOfPlace(int place) {
  KindCells cells{"place" + std::to_string(place), "place" + std::to_string(place), {}};
  for (int i = 0; i < 300; ++i) {
    KindCell cell;
    cell.cues.fill(kUnknown);
    const float value = 0.01f * static_cast<float>(i);
    cell.cues[static_cast<size_t>(Cue::kDetail)] = value;
    cell.cues[static_cast<size_t>(Cue::kGreennessContrast)] = static_cast<float>(place);
    cell.is_fit = value > 1.0f && value < 2.0f ? 1.0f : 0.0f;
    cell.kind = cell.is_fit > 0.0f ? "meadow" : "soil";
    cell.weight = 10.0f;
    cells.cells.push_back(cell);
  }
  return cells;
}

KindProblem Problem() {
  return KindProblem({CellsOfPlace(1), CellsOfPlace(2), CellsOfPlace(3)}, {12, 0.1});
}

TEST_CASE("kinds: a cue that is good in the middle of its range is learnt at places left out") {
  const KindProblem problem = Problem();
  CueSet cues;
  cues.set(static_cast<size_t>(Cue::kDetail));
  for (const GroupScore& score : ScoreGroups(problem, ScoresLeftOut(problem, cues), 0.0)) {
    CHECK(score.auc > 0.97);
    CHECK(score.recall > 0.9);
    CHECK(score.false_share < 0.1);
  }
}

TEST_CASE("kinds: a cue that only names the place lowers no loss at places left out") {
  const KindProblem problem = Problem();
  CueSet cues;
  cues.set(static_cast<size_t>(Cue::kGreennessContrast));
  for (const GroupScore& score : ScoreGroups(problem, ScoresLeftOut(problem, cues), 0.0)) {
    CHECK(score.log_loss > std::log(2.0) - 0.01);
  }
}

TEST_CASE("kinds: the model for the engine gives the scores of the fit") {
  const KindProblem problem = Problem();
  CueSet cues;
  cues.set(static_cast<size_t>(Cue::kDetail));
  const Eigen::VectorXd fit =
      problem.Fit(cues, std::nullopt, Eigen::VectorXd::Zero(problem.num_columns()), 12);
  const KindModel model = problem.ModelOf(cues, fit);
  REQUIRE(model.terms.size() == 1);
  for (const size_t i : {size_t{3}, size_t{150}, size_t{299}}) {
    const float value = 0.01f * static_cast<float>(i);
    CHECK(model.offset + model.terms[0].At(value) ==
          doctest::Approx(problem.ScoreOf(problem.rows()[i], cues, fit)).epsilon(1e-3));
  }
}

TEST_CASE("kinds: cells are the same after writing and reading") {
  const std::string path = (std::filesystem::temp_directory_path() / "freelsd_kinds.csv").string();
  const KindCells cells = CellsOfPlace(2);
  WriteCells(path, cells);
  const KindCells read = ReadCells(path);
  CHECK(read.group == cells.group);
  REQUIRE(read.cells.size() == cells.cells.size());
  CHECK(read.cells[120].kind == "meadow");
  CHECK(read.cells[120].cues[static_cast<size_t>(Cue::kDetail)] == doctest::Approx(1.2));
  CHECK(std::isnan(read.cells[120].cues[0]));
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace freelsd
