// What the programs that judge have in common: many pieces of work at once, and reports that are
// continued.
#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include <nlohmann/json_fwd.hpp>

namespace freelsd {

// Does the pieces 0 to num_pieces - 1, in this order, on so many threads. `work` is called by
// several of them at once. After a failure no further piece begins, and the first exception is
// thrown on.
void DoAll(size_t num_pieces, int num_jobs, const std::function<void(size_t)>& work);

// The report at a path, to be continued; an empty object if there is no file. Throws
// std::runtime_error if it was made with other settings.
nlohmann::json ReadReportToContinue(const std::string& path, const nlohmann::json& settings);

std::string ReadTextFile(const std::string& path);
// Whole or not at all: a run that is interrupted must not spoil what it would go on from.
void WriteTextFile(const std::string& path, const std::string& text);

}  // namespace freelsd
