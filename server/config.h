// Settings of freelsd-server: command line over configuration file over defaults.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace freelsd {

struct Address {
  std::string host = "127.0.0.1";
  // 0: any free port.
  int port = 8080;
};

struct Config {
  std::filesystem::path data;
  std::string host = "127.0.0.1";
  // 0: any free port.
  int port = 8080;
  // Listener with threads of its own for /v1/emergency and /healthz; nothing: none.
  std::optional<Address> emergency;
  // The grass classifier and the page; found beside the program when empty.
  std::filesystem::path model;
  std::filesystem::path page;
  // Hashes of the tokens that are let in; empty: nobody is asked for one.
  std::filesystem::path token_file;
  // Host names besides the loopback ones that requests may name.
  std::vector<std::string> allowed_hosts;
  int num_http_threads = 32;
  // Frames that may wait for the frontend; batches are outside this limit.
  int64_t max_num_queued_frames = 256;
  // Flights that the engine holds in memory at a time; frames of others wait.
  int max_num_open_flights = 16;
  uint64_t max_batch_bytes = uint64_t{2} << 30;
  // Images of idle flights are removed, oldest first, beyond these; 0: never. Sites stay.
  double max_image_age_days = 0.0;
  uint64_t max_stored_image_bytes = 0;
  // How long a frame without position waits for telemetry that covers its time.
  double telemetry_wait_s = 10.0;
  // Longest time between two telemetry samples that is bridged, and the longest that a pose is
  // taken beyond the last one.
  double max_telemetry_gap_s = 2.0;
  double max_telemetry_extrapolation_s = 0.2;
};

// What is wrong with the settings, in a sentence.
class ConfigError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Nothing when help or the version was asked for and printed. Throws ConfigError.
std::optional<Config> ReadConfig(int argc, const char* const* argv);

// "127.0.0.1:8080", "[::1]:8080". Throws ConfigError.
Address ParseAddress(const std::string& listen);

}  // namespace freelsd
