// freelsd-fuzz: runs every target on its seeds, then on seeds that are changed at random, the same
// way each time. It stands in for libFuzzer where there is only g++: no coverage guides it.
//
//   freelsd-fuzz SEEDS [--seconds N] [--target NAME] [--write FILE]
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>

#include <CLI/CLI.hpp>

#include "tests/fuzz/targets.h"

namespace freelsd {
namespace {

const std::vector<std::string> kTokens{
    "1e308",       "1e999", "NaN",  "-0",      "null",
    "{}",          "[[[[",  "\"",   "\\u0000", "\xff\xff",
    "%00",         "..",    "\r\n", "\r\n",    ",",
    "\n---x",      "--x--", "true", "1e-320",  ":",
    "  ",          "\t",    "-1",   "0",       "9223372036854775807",
    "\xe2\x80\xa8"};

std::vector<std::string> ReadSeeds(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  std::vector<std::string> seeds;
  for (const auto& file : files) {
    std::ifstream stream(file, std::ios::binary);
    seeds.emplace_back(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
  }
  return seeds;
}

// The same inputs on every machine: only what the standard fixes of std::mt19937 is used.
class Mutator {
 public:
  std::string Changed(const std::vector<std::string>& seeds, size_t max_bytes) {
    std::string bytes = seeds[Below(seeds.size())];
    const size_t num_changes = 1 + Below(6);
    for (size_t i = 0; i < num_changes; ++i) ChangeOnce(seeds, bytes);
    if (bytes.size() > max_bytes) bytes.resize(max_bytes);
    return bytes;
  }

 private:
  size_t Below(size_t bound) { return bound == 0 ? 0 : random_() % bound; }

  void ChangeOnce(const std::vector<std::string>& seeds, std::string& bytes) {
    const size_t at = Below(bytes.size() + 1);
    const size_t length = std::min(bytes.size() - at, 1 + Below(32));
    const std::string& other = seeds[Below(seeds.size())];
    const size_t from = Below(other.size() + 1);
    switch (Below(7)) {
      case 0:
        if (at < bytes.size()) bytes[at] = static_cast<char>(bytes[at] ^ (1 << Below(8)));
        break;
      case 1:
        if (at < bytes.size()) bytes[at] = static_cast<char>(random_());
        break;
      case 2:
        bytes.erase(at, length);
        break;
      case 3:
        bytes.insert(at, bytes.substr(at, length));
        break;
      case 4:
        bytes.insert(at, kTokens[Below(kTokens.size())]);
        break;
      case 5:
        bytes.replace(at, length, kTokens[Below(kTokens.size())]);
        break;
      default:
        bytes = bytes.substr(0, at) + other.substr(from);
    }
  }

  std::mt19937 random_{1};
};

struct Arguments {
  std::string seeds;
  double seconds = 2.0;
  std::string target;
  // The input at hand is kept there, for when the process ends within it.
  std::string kept_input;
};

void Keep(const Arguments& arguments, const std::string& bytes) {
  if (!arguments.kept_input.empty()) {
    std::ofstream(arguments.kept_input, std::ios::binary) << bytes;
  }
}

void Run(const FuzzTarget& target, const Arguments& arguments) {
  const std::vector<std::string> seeds =
      ReadSeeds(std::filesystem::path(arguments.seeds) / target.name);
  if (seeds.empty()) throw std::runtime_error(std::string("no seeds for ") + target.name);
  const auto end =
      std::chrono::steady_clock::now() + std::chrono::duration<double>(arguments.seconds);
  for (const std::string& seed : seeds) {
    Keep(arguments, seed);
    RunSafely(target, seed);
  }
  Mutator mutator;
  size_t num_runs = seeds.size();
  for (; target.max_bytes > 0 && std::chrono::steady_clock::now() < end; ++num_runs) {
    const std::string bytes = mutator.Changed(seeds, target.max_bytes);
    Keep(arguments, bytes);
    RunSafely(target, bytes);
  }
  std::printf("%-16s %4zu seeds %8zu inputs\n", target.name, seeds.size(), num_runs);
  std::fflush(stdout);
}

}  // namespace
}  // namespace freelsd

int main(int argc, char** argv) {
  try {
    freelsd::Arguments arguments;
    CLI::App app("Runs every parser on seeds and on changed seeds.");
    app.add_option("seeds", arguments.seeds, "folder with one folder per target")->required();
    app.add_option("--seconds", arguments.seconds, "of changed seeds per target");
    app.add_option("--target", arguments.target, "only this one");
    app.add_option("--write", arguments.kept_input, "file that always holds the input at hand");
    CLI11_PARSE(app, argc, argv);
    for (const freelsd::FuzzTarget& target : freelsd::FuzzTargets()) {
      if (arguments.target.empty() || arguments.target == target.name) {
        freelsd::Run(target, arguments);
      }
    }
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "freelsd-fuzz: %s\n", error.what());
    return 1;
  }
}
