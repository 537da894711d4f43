// Settings of freelsd-server. The command line overrides the configuration file, and the file
// overrides the defaults.
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

// What a server does among several on one PostgreSQL database: kApi answers and stores, kWorker
// computes, kAll does both.
enum class Role { kApi, kWorker, kAll };

struct Config {
  // Folder of the database and the images; with `database`, of this process's uploads alone.
  std::filesystem::path data;
  // URI of a PostgreSQL database, without a password; empty: SQLite in `data`.
  std::string database;
  // Folder of the images, which all servers on the same PostgreSQL database share.
  std::filesystem::path images;
  // Empty: the server has its database for itself.
  std::optional<Role> role;
  std::string host = "127.0.0.1";
  // 0: any free port.
  int port = 8080;
  // Second listener for /v1/emergency, its export and /healthz. It has its own threads. Empty: no
  // such listener.
  std::optional<Address> emergency;
  // Grass classifier, and folder of the web page. Empty: the ones installed beside the program.
  std::filesystem::path model;
  std::filesystem::path page;
  // File with hashes of the accepted tokens; empty: requests need no token.
  std::filesystem::path token_file;
  // Host names that a request's Host header may contain in addition to loopback names.
  std::vector<std::string> allowed_hosts;
  int num_http_threads = 32;
  // Largest number of frames that wait to be processed. Frames of batches do not count.
  int64_t max_num_queued_frames = 256;
  // Largest number of flights that the engine holds in memory. Frames of other flights wait.
  int max_num_open_flights = 16;
  // Sites in the list of alternates that is kept for each live flight.
  int num_alternates = 3;
  // Memory for what recall keeps between answers: sites with their maps, terrain, plans.
  int recall_cache_mib = 384;
  uint64_t max_batch_bytes = uint64_t{2} << 30;
  // If a limit is exceeded, images of idle flights are removed, oldest flight first. Sites are
  // kept. 0: no limit.
  double max_image_age_days = 0.0;
  uint64_t max_stored_image_bytes = 0;
  // How long a frame without a position waits for telemetry that covers its timestamp.
  double telemetry_wait_s = 10.0;
  // Longest time between two telemetry samples across which a pose is interpolated.
  double max_telemetry_gap_s = 2.0;
  // Longest time between a frame and a single telemetry sample that gives its pose.
  double max_telemetry_extrapolation_s = 0.2;
  // The page's base map: at most one of a URL template of tiles with {z}, {x} and {y}, which
  // browsers fetch from elsewhere, and an MBTiles file, which this server reads. Empty: none.
  std::string base_map_url;
  std::filesystem::path base_map_file;
  // Whom the map is from. Empty: as the file's metadata says.
  std::string base_map_attribution;
  // Largest zoom level that the page may ask for. Nothing: 19, or the file's.
  std::optional<int> base_map_max_zoom;
  // Address of a server whose sites, maps and obstacles this one keeps a copy of, the area of the
  // copy ("west,south,east,north" in degrees), and the file with the token for it. Empty: none.
  std::string follow;
  std::string area;
  std::filesystem::path follow_token_file;
};

// Thrown if a setting is invalid. what() is a sentence for the operator.
class ConfigError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Reads the settings. Prints help or version and returns nothing if the command line asks for it.
// Throws ConfigError.
std::optional<Config> ReadConfig(int argc, const char* const* argv);

// Parses "127.0.0.1:8080" or "[::1]:8080". Throws ConfigError.
Address ParseAddress(const std::string& listen);

}  // namespace freelsd
