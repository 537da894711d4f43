#include "tests/evaluation/runs/runs.h"

#include <atomic>
#include <exception>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <sstream>
#include <stdexcept>
#include <thread>

#include <nlohmann/json.hpp>

namespace freelsd {

using Json = nlohmann::json;

void DoAll(size_t num_pieces, int num_jobs, const std::function<void(size_t)>& work) {
  std::atomic<size_t> next = 0;
  std::atomic<bool> has_failed = false;
  // Guards failure.
  std::mutex mutex;
  std::exception_ptr failure;
  const auto do_some = [&] {
    try {
      for (size_t i = next++; i < num_pieces && !has_failed; i = next++) work(i);
    } catch (...) {  // handed on to the thread that waits
      const std::lock_guard<std::mutex> lock(mutex);
      if (!has_failed.exchange(true)) failure = std::current_exception();
    }
  };
  std::vector<std::thread> threads;
  threads.reserve(static_cast<size_t>(num_jobs));
  for (int i = 1; i < num_jobs; ++i) threads.emplace_back(do_some);
  do_some();
  for (std::thread& thread : threads) thread.join();
  if (failure) std::rethrow_exception(failure);
}

Json ReadReportToContinue(const std::string& path, const Json& settings) {
  if (!std::filesystem::exists(path)) return Json::object();
  Json report = Json::parse(ReadTextFile(path));
  if (report.at("settings") != settings) {
    throw std::runtime_error(path +
                             " was made with other settings: " + report.at("settings").dump());
  }
  return report;
}

std::string ReadTextFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("cannot read " + path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

void WriteTextFile(const std::string& path, const std::string& text) {
  const std::string part = path + ".part";
  {
    std::ofstream file(part, std::ios::binary);
    file << text;
    file.flush();
    if (!file) throw std::runtime_error("cannot write " + part);
  }
  std::filesystem::rename(part, path);
}

}  // namespace freelsd
