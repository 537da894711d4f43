// freelsd-kinds: cues of ground whose kind is known, and the model of kinds that is fitted to them.
#include <algorithm>
#include <cmath>
#include <exception>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <map>
#include <sstream>

#include <CLI/CLI.hpp>

#include "tests/evaluation/kinds/kind_scores.h"
#include "tests/evaluation/kinds/kind_sources.h"
#include "tests/evaluation/runs/runs.h"

namespace freelsd {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  std::string folder;
  std::string flight;
  std::string model = FREELSD_SOURCE_DIR "/engine/classification/grass_model.yml";
  ScenarioOptions scenario;
  int num_worlds = 4;
  uint64_t seed = 1000;
  size_t max_num_cells = 1500;
  KindSourceOptions source;
  KindFitOptions fit;
  size_t every = 1;
  bool chooses_cues = false;
  // Each file of cells is a group of its own.
  bool leaves_out_files = false;
  std::vector<std::string> only;
  bool prints_cues = true;
  std::vector<std::string> without;
  std::string table;
  double min_score = 2.0;
};

// Throws std::invalid_argument for all but tuning data.
void RequireTuning(const std::string& what, std::optional<Pool> pool) {
  if (pool != Pool::kTuning) throw std::invalid_argument(what + " is not of the tuning pool");
}

std::string GroupOf(const ScenarioOptions& scenario) {
  if (!scenario.ground.empty()) return scenario.ground;
  return scenario.texture == "recorded" ? "textured" : "painted";
}

void WriteSource(const Arguments& arguments,
                 const std::string& group,
                 const std::string& name,
                 const KindRasters& rasters) {
  const KindCells cells{group, name, DrawCells(rasters, arguments.max_num_cells)};
  WriteCells(arguments.folder + "/" + name + ".csv", cells);
  std::cerr << name << ": " << cells.cells.size() << " cells" << std::endl;
}

void WriteAllCells(const Arguments& arguments) {
  cv::setNumThreads(1);
  const Classifier classifier = Classifier::Parse(ReadTextFile(arguments.model));
  if (!arguments.flight.empty()) {
    const std::string name = fs::path(arguments.flight).filename().string();
    RequireTuning("flight " + name, EvaluationPools().Of("flight", name));
    WriteSource(
        arguments, name, name, KindsOfFlight(arguments.flight, classifier, arguments.source));
    return;
  }
  const ScenarioOptions& scenario = arguments.scenario;
  if (!scenario.ground.empty()) {
    RequireTuning("ground " + scenario.ground, EvaluationPools().Of("ground", scenario.ground));
  }
  for (int world = 0; world < arguments.num_worlds; ++world) {
    const uint64_t seed = arguments.seed + static_cast<uint64_t>(world);
    RequireTuning("seed " + std::to_string(seed), EvaluationPools().OfSeed(seed));
    const std::string group = GroupOf(scenario);
    WriteSource(arguments,
                group,
                (scenario.ground.empty() ? "" : "ground-") + group + "-" + std::to_string(seed),
                KindsOfWorld(seed, scenario, classifier, arguments.source));
  }
}

// Every n-th cell of each file.
std::vector<KindCells> ReadAllCells(const std::string& folder, size_t every) {
  std::vector<fs::path> paths;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".csv") paths.push_back(entry.path());
  }
  std::sort(paths.begin(), paths.end());
  std::vector<KindCells> all;
  all.reserve(paths.size());
  for (const fs::path& path : paths) {
    KindCells cells = ReadCells(path.string());
    std::vector<KindCell> kept;
    for (size_t i = 0; i < cells.cells.size(); i += every) kept.push_back(cells.cells[i]);
    cells.cells = std::move(kept);
    all.push_back(std::move(cells));
  }
  return all;
}

// Mean log loss of the groups that recorded photographs show.
double RecordedLoss(const KindProblem& problem, const std::vector<GroupScore>& scores) {
  double sum = 0.0, count = 0.0;
  for (size_t group = 0; group < scores.size(); ++group) {
    if (!problem.IsRecorded(group)) continue;
    sum += problem.WeightOf(group) * scores[group].log_loss;
    count += problem.WeightOf(group);
  }
  return sum / count;
}

void PrintGroups(const KindProblem& problem, const std::vector<GroupScore>& scores) {
  std::cout << "| left out | log loss | AUC | recall of grass | of other ground, called grass | of "
               "ground called grass, other |\n|---|---|---|---|---|---|\n";
  for (size_t group = 0; group < scores.size(); ++group) {
    const GroupScore& score = scores[group];
    std::cout << std::fixed << std::setprecision(4) << "| " << problem.groups()[group] << " | "
              << score.log_loss << " | " << score.auc << " | " << score.recall << " | "
              << score.false_share << " | " << score.false_among_called << " |\n";
  }
  std::cout << "Mean log loss on recorded photographs: " << RecordedLoss(problem, scores) << "\n";
}

// Which share of grass is called grass, and which share of what is called grass is not, by score.
void PrintOperatingPoints(const KindProblem& problem, const std::vector<double>& scores) {
  constexpr double kFirst = -0.5, kLast = 5.0, kStep = 0.5;
  std::cout << "\n| score: recall of grass / other among called grass |";
  for (const std::string& group : problem.groups()) std::cout << " " << group << " |";
  std::cout << "\n|---|" << std::string(problem.groups().size() * 4, '-') << "\n";
  for (double least = kFirst; least <= kLast; least += kStep) {
    std::cout << std::fixed << std::setprecision(1) << "| " << least << " |";
    for (const GroupScore& score : ScoreGroups(problem, scores, least)) {
      std::cout << std::setprecision(2) << " " << score.recall << " / " << std::setprecision(3)
                << score.false_among_called << " |";
    }
    std::cout << "\n";
  }
}

// Shares called grass, by group and kind.
void PrintKinds(const KindProblem& problem, const std::vector<double>& scores, double min_score) {
  std::map<std::pair<std::string, std::string>, std::pair<double, double>> counts;
  for (size_t i = 0; i < scores.size(); ++i) {
    const KindProblem::Row& row = problem.rows()[i];
    auto& [called, all] = counts[{row.kind, problem.groups()[row.group]}];
    all += row.num_cells;
    if (scores[i] >= min_score) called += row.num_cells;
  }
  std::cout << "\n| kind | left out | cells | called grass |\n|---|---|---|---|\n";
  for (const auto& [key, count] : counts) {
    std::cout << "| " << key.first << " | " << key.second << " | " << std::setprecision(0)
              << count.second << " | " << std::setprecision(4) << count.first / count.second
              << " |\n";
  }
}

// Steps of a fit that begins with the fit of one cue more or less.
constexpr int kNumQuickSteps = 3;

struct CueLoss {
  size_t cue = 0;
  double recorded = 0.0;
  std::vector<double> by_group;
};

// Change of the log loss when each cue is left out; the least harmful first.
std::vector<CueLoss> LossesWithout(const KindProblem& problem, const CueSet& cues) {
  const std::vector<Eigen::VectorXd> fits = FitsLeftOut(problem, cues);
  const std::vector<GroupScore> with =
      ScoreGroups(problem, ScoresFrom(problem, cues, fits, 0), 0.0);
  std::vector<CueLoss> losses;
  for (size_t cue = 0; cue < kNumCues; ++cue) {
    if (!cues[cue]) continue;
    CueSet fewer = cues;
    fewer.reset(cue);
    const std::vector<GroupScore> without =
        ScoreGroups(problem, ScoresFrom(problem, fewer, fits, kNumQuickSteps), 0.0);
    CueLoss loss{cue, RecordedLoss(problem, without) - RecordedLoss(problem, with), {}};
    for (size_t group = 0; group < with.size(); ++group) {
      loss.by_group.push_back(without[group].log_loss - with[group].log_loss);
    }
    losses.push_back(std::move(loss));
  }
  std::sort(losses.begin(), losses.end(), [](const CueLoss& a, const CueLoss& b) {
    return a.recorded < b.recorded;
  });
  return losses;
}

void PrintCues(const KindProblem& problem, const std::vector<CueLoss>& losses) {
  std::cout << "\n| without the cue | recorded |";
  for (const std::string& group : problem.groups()) std::cout << " " << group << " |";
  std::cout << "\n|---|---|" << std::string(problem.groups().size() * 4, '-') << "\n";
  for (const CueLoss& loss : losses) {
    std::cout << std::showpos << std::fixed << std::setprecision(4) << "| " << kCueNames[loss.cue]
              << " | " << loss.recorded << " |";
    for (const double change : loss.by_group) std::cout << " " << change << " |";
    std::cout << std::noshowpos << "\n";
  }
}

// Least drop of the mean log loss on recorded photographs that a cue must bring.
constexpr double kLeastUse = 0.001;

// Adds the most useful cue of those allowed, one by one, and then drops those that have become
// useless.
CueSet UsefulCues(const KindProblem& problem, const CueSet& allowed) {
  CueSet cues;
  double loss = std::log(2.0);
  while (cues != allowed) {
    const std::vector<Eigen::VectorXd> fits = FitsLeftOut(problem, cues);
    std::map<double, size_t> by_loss;
    for (size_t cue = 0; cue < kNumCues; ++cue) {
      if (!allowed[cue] || cues[cue]) continue;
      CueSet more = cues;
      more.set(cue);
      const std::vector<double> scores = ScoresFrom(problem, more, fits, kNumQuickSteps);
      by_loss[RecordedLoss(problem, ScoreGroups(problem, scores, 0.0))] = cue;
    }
    const auto [least, best] = *by_loss.begin();
    if (least > loss - kLeastUse) break;
    cues.set(best);
    loss = least;
    std::cout << "added " << kCueNames[best] << ": " << std::fixed << std::setprecision(4) << loss
              << std::endl;
  }
  while (cues.count() > 1) {
    const CueLoss least = LossesWithout(problem, cues).front();
    if (least.recorded > kLeastUse) break;
    std::cout << "dropped " << kCueNames[least.cue] << ": " << std::showpos << least.recorded
              << std::noshowpos << std::endl;
    cues.reset(least.cue);
  }
  return cues;
}

std::string NumbersOf(const std::vector<float>& values) {
  std::ostringstream text;
  for (size_t i = 0; i < values.size(); ++i) {
    text << (i == 0 ? "" : ", ") << std::fixed << std::setprecision(5) << values[i] << "f";
  }
  return "{" + text.str() + "}";
}

std::string NameInCode(const std::string& name) {
  std::string code = "k";
  bool is_upper = true;
  for (const char letter : name) {
    if (letter != '_') code += is_upper ? static_cast<char>(letter - 'a' + 'A') : letter;
    is_upper = letter == '_';
  }
  return code;
}

std::string TableOf(const KindModel& model) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(5)
       << "// Written by `freelsd-kinds fit`. Do not edit.\n"
          "#include \"engine/cover/kind/kind.h\"\n\nnamespace freelsd {\n\n"
          "// NOLINTNEXTLINE(readability-function-size): a table.\n"
          "const KindModel& ShippedKindModel() {\n  static const KindModel kModel{\n      "
       << model.offset << "f,\n      {\n";
  for (const CueTerm& term : model.terms) {
    text << "          {Cue::" << NameInCode(kCueNames[static_cast<size_t>(term.cue)])
         << ",\n           " << NumbersOf(term.knots) << ",\n           "
         << NumbersOf(term.log_odds) << ",\n           " << term.unknown_log_odds << "f},\n";
  }
  text << "      },\n      {\n";
  for (const EarnedStep& step : model.earned) {
    text << "          {" << step.min_score << "f, " << step.probability << "f},\n";
  }
  text << "      }};\n  return kModel;\n}\n\n}  // namespace freelsd\n";
  return text.str();
}

void Fit(const Arguments& arguments) {
  std::vector<KindCells> all = ReadAllCells(arguments.folder, arguments.every);
  if (arguments.leaves_out_files) {
    for (KindCells& cells : all) cells.group = cells.name;
  }
  const KindProblem problem(all, arguments.fit);
  CueSet cues;
  for (size_t cue = 0; cue < kNumCues; ++cue) {
    const auto names = [&](const std::vector<std::string>& list) {
      return std::find(list.begin(), list.end(), kCueNames[cue]) != list.end();
    };
    cues[cue] = !names(arguments.without) && (arguments.only.empty() || names(arguments.only));
  }
  if (arguments.chooses_cues) cues = UsefulCues(problem, cues);
  const std::vector<double> scores = ScoresLeftOut(problem, cues);
  PrintGroups(problem, ScoreGroups(problem, scores, arguments.min_score));
  PrintOperatingPoints(problem, scores);
  PrintKinds(problem, scores, arguments.min_score);
  if (arguments.prints_cues) PrintCues(problem, LossesWithout(problem, cues));
  KindModel model = problem.ModelOf(
      cues, problem.Fit(cues, std::nullopt, Eigen::VectorXd::Zero(problem.num_columns()), 12));
  model.earned = EarnedSteps(problem, scores);
  std::cout << "\n| score | probability earned |\n|---|---|\n";
  for (const EarnedStep& step : model.earned) {
    std::cout << "| " << step.min_score << " | " << step.probability << " |\n";
  }
  if (!arguments.table.empty()) WriteTextFile(arguments.table, TableOf(model));
}

void AddCellOptions(CLI::App& app, Arguments& arguments) {
  app.add_option("--out", arguments.folder, "folder for files of cells")->required();
  app.add_option("--flight", arguments.flight, "folder of a recorded flight; else worlds");
  app.add_option("--worlds", arguments.num_worlds, "number of worlds");
  app.add_option("--seed", arguments.seed, "seed of the first world");
  app.add_option("--ground", arguments.scenario.ground, "a pack of FREELSD_DATA/terrain");
  app.add_option("--texture", arguments.scenario.texture, "painted or recorded");
  app.add_option("--conditions", arguments.scenario.conditions, "plain or recorded");
  app.add_option("--cell", arguments.scenario.cell_size_m, "texture of a world in metres");
  app.add_option("--cells", arguments.max_num_cells, "largest number of cells of a kind");
  app.add_option("--model", arguments.model, "grass classifier");
  app.add_option("--pictures", arguments.source.pictures, "folder for orthophotos with kinds");
}

void AddFitOptions(CLI::App& app, Arguments& arguments) {
  app.add_option("--cells", arguments.folder, "folder with files of cells")->required();
  app.add_option("--ridge", arguments.fit.ridge, "penalty of squared coefficients");
  app.add_option("--knots", arguments.fit.num_knots, "knots of a cue")->check(CLI::Range(2, 20));
  app.add_option("--every", arguments.every, "use every n-th cell alone")
      ->check(CLI::Range(1, 100));
  app.add_flag("--no-ablation{false}", arguments.prints_cues, "without the table of cues");
  app.add_flag("--choose", arguments.chooses_cues, "take the useful cues alone");
  app.add_flag("--by-file", arguments.leaves_out_files, "leave out single files, not groups");
  app.add_option("--only", arguments.only, "cues to use")->delimiter(',');
  app.add_option("--without", arguments.without, "cues to leave out")->delimiter(',');
  app.add_option("--min-score", arguments.min_score, "score from which ground is called grass");
  app.add_option("--table", arguments.table, "source file to write with the model");
}

}  // namespace
}  // namespace freelsd

int main(int argc, char** argv) {
  try {
    freelsd::Arguments arguments;
    CLI::App app("Fits the model of the ground's kind to cells whose kind is known.");
    app.require_subcommand(1);
    CLI::App* cells = app.add_subcommand("cells", "write cues of cells whose kind is known");
    CLI::App* fit = app.add_subcommand("fit", "fit the model, with each group left out in turn");
    freelsd::AddCellOptions(*cells, arguments);
    freelsd::AddFitOptions(*fit, arguments);
    CLI11_PARSE(app, argc, argv);
    if (cells->parsed()) freelsd::WriteAllCells(arguments);
    if (fit->parsed()) freelsd::Fit(arguments);
  } catch (const std::exception& error) {
    std::cerr << "freelsd-kinds: " << error.what() << "\n";
    return 1;
  }
  return 0;
}
