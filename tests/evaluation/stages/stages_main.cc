// freelsd-stages: what each stage makes of a rendered flight, kept in a file, and how two such
// files differ, for example of two processors.
#include <exception>
#include <iomanip>
#include <iostream>

#include <CLI/CLI.hpp>

#include "tests/evaluation/stages/mathematics.h"
#include "tests/evaluation/stages/stage_run.h"

namespace freelsd {
namespace {

constexpr int kNumArguments = 200000;

struct Arguments {
  std::string flight_folder;
  std::string adjusted;
  std::string out;
  std::string a, b;
  size_t max_num_frames = 1000000;
};

// Returns true if all is equal.
bool Print(const std::vector<StageDifference>& differences) {
  std::string first;
  std::cout << "| stage | quantity | values | unequal | known in one | largest difference | RMS |\n"
            << "|---|---|---|---|---|---|---|\n"
            << std::setprecision(3);
  for (const StageDifference& each : differences) {
    if (first.empty() && !each.IsEqual()) first = each.stage + ": " + each.quantity;
    std::cout << "| " << each.stage << " | " << each.quantity << " | " << each.num_values_a;
    if (each.num_values_a != each.num_values_b) {
      std::cout << " and " << each.num_values_b << " | | | | |\n";
      continue;
    }
    std::cout << " | " << each.num_unequal << " | " << each.num_known_in_one << " | "
              << each.largest << " | " << each.root_mean_square << " |\n";
  }
  std::cout << (first.empty() ? "all equal" : "the first that differs is " + first) << "\n";
  return first.empty();
}

}  // namespace
}  // namespace freelsd

int main(int argc, char** argv) {
  try {
    freelsd::Arguments arguments;
    CLI::App app("Records what each stage makes of a rendered flight, and compares two records.");
    app.require_subcommand(1);
    auto* run = app.add_subcommand("run", "one stage after the other");
    auto* alone = app.add_subcommand("alone", "stages on recorded input");
    alone->add_option("--adjusted", arguments.adjusted, "file of `run`")->required();
    for (auto* command : {run, alone}) {
      command->add_option("folder", arguments.flight_folder, "of freelsd-render")->required();
      command->add_option("--out", arguments.out, "file to write")->required();
      command->add_option("--frames", arguments.max_num_frames, "only so many photographs");
    }
    auto* mathematics = app.add_subcommand("mathematics", "functions of the C library");
    mathematics->add_option("--out", arguments.out, "file to write")->required();
    auto* compare = app.add_subcommand("compare", "status 1 if they differ");
    compare->add_option("a", arguments.a)->required();
    compare->add_option("b", arguments.b)->required();
    CLI11_PARSE(app, argc, argv);
    if (compare->parsed()) {
      const bool is_equal = freelsd::Print(
          freelsd::Compare(freelsd::ReadRecords(arguments.a), freelsd::ReadRecords(arguments.b)));
      return is_equal ? 0 : 1;
    }
    if (mathematics->parsed()) {
      freelsd::WriteRecords(arguments.out, freelsd::RunMathematics(freelsd::kNumArguments));
      return 0;
    }
    const auto flight =
        freelsd::ReadFlightFolder(arguments.flight_folder, arguments.max_num_frames);
    freelsd::WriteRecords(
        arguments.out,
        run->parsed() ? freelsd::RunStages(flight)
                      : freelsd::RunStagesAlone(flight, freelsd::ReadRecords(arguments.adjusted)));
  } catch (const std::exception& error) {
    std::cerr << "freelsd-stages: " << error.what() << "\n";
    return 2;
  }
  return 0;
}
