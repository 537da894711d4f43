// freelsd-bench: what the stages cost, each beside the plain way of doing the same in the same run.
#include <cmath>
#include <cstdio>
#include <exception>
#include <fstream>
#include <iostream>
#include <sstream>
#include <stdexcept>
#include <string>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "tests/bench/contest.h"

namespace freelsd {
namespace {

using Json = nlohmann::json;

struct Arguments {
  std::string filter;
  std::string json;
  std::string model = FREELSD_SOURCE_DIR "/engine/ground_kind/ground_kind.onnx";
  int num_runs = 20;
  int num_threads = 1;
};

Json JsonOf(const Row& row) {
  Json json{{"name", row.name},
            {"size", row.size},
            {"threads", row.threads},
            {"median_ms", row.engine.wall_ms},
            {"processor_ms", row.engine.processor_ms},
            {"baseline", nullptr},
            {"baseline_ms", nullptr},
            {"baseline_processor_ms", nullptr},
            {"ratio", nullptr},
            {"processor_ratio", nullptr}};
  if (!row.note.empty()) json["note"] = row.note;
  if (row.baseline.empty()) return json;
  json["baseline"] = row.baseline;
  json["baseline_ms"] = row.plain.wall_ms;
  json["baseline_processor_ms"] = row.plain.processor_ms;
  json["ratio"] = row.plain.wall_ms / row.engine.wall_ms;
  json["processor_ratio"] = row.plain.processor_ms / row.engine.processor_ms;
  return json;
}

void PrintRow(const Row& row) {
  std::printf("%-18s %-28s %9.3f %9.3f",
              row.name.c_str(),
              row.size.c_str(),
              row.engine.wall_ms,
              row.engine.processor_ms);
  if (!row.baseline.empty()) {
    std::printf(" %9.3f %9.3f  x %-7.3g %s",
                row.plain.wall_ms,
                row.plain.processor_ms,
                row.plain.processor_ms / row.engine.processor_ms,
                row.baseline.c_str());
  }
  std::printf("\n");
  if (!row.note.empty()) std::printf("%-18s %s\n", "", row.note.c_str());
  std::fflush(stdout);
}

void Run(const Arguments& arguments) {
  cv::setNumThreads(arguments.num_threads);
  std::vector<Entry> entries = FrontendEntries(arguments.model);
  for (Entry& entry : ReconstructionEntries(arguments.model)) entries.push_back(std::move(entry));
  for (Entry& entry : MapEntries()) entries.push_back(std::move(entry));
  for (Entry& entry : ReachEntries()) entries.push_back(std::move(entry));
  for (Entry& entry : KernelEntries(arguments.model)) entries.push_back(std::move(entry));
  std::printf("%-18s %-28s %9s %9s %9s %9s  plain / engine, processor time\n",
              "milliseconds",
              "",
              "engine",
              "processor",
              "plain",
              "processor");
  Json rows = Json::array();
  for (const Entry& entry : entries) {
    if (entry.name.find(arguments.filter) == std::string::npos) continue;
    const Row row = Measure(entry.prepare(), arguments.num_runs, arguments.num_threads);
    PrintRow(row);
    rows.push_back(JsonOf(row));
  }
  if (rows.empty()) throw std::invalid_argument("no stage is named like " + arguments.filter);
  if (arguments.json.empty()) return;
  std::ofstream file(arguments.json, std::ios::binary);
  file << rows.dump(1) << "\n";
  file.flush();
  if (!file) throw std::runtime_error("cannot write " + arguments.json);
}

}  // namespace
}  // namespace freelsd

int main(int argc, char** argv) {
  try {
    freelsd::Arguments arguments;
    CLI::App app("Measures the engine's stages. Median of the runs, in milliseconds.");
    app.add_option("--filter", arguments.filter, "stages whose name holds this");
    app.add_option("--json", arguments.json, "file for the rows");
    app.add_option("--model", arguments.model, "network of ground kinds");
    app.add_option("--runs", arguments.num_runs, "runs of each")->check(CLI::Range(20, 10000));
    app.add_option("--threads", arguments.num_threads, "threads of OpenCV")
        ->check(CLI::Range(1, 64));
    CLI11_PARSE(app, argc, argv);
    freelsd::Run(arguments);
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "freelsd-bench: " << error.what() << "\n";
    return 1;
  }
}
