#include "storage/mbtiles.h"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <map>
#include <mutex>
#include <string_view>

#include "storage/sqlite/sqlite.h"
#include "storage/storage_error.h"

namespace freelsd {
namespace {

using SteadyClock = std::chrono::steady_clock;

// Tiles of this zoom level are 4 cm wide.
constexpr int kMaxZoom = 30;
// Steps of SQLite's machine between two looks at the clock. An indexed search takes fewer.
constexpr int kStepsPerLook = 1000;
// Longer texts are cut.
constexpr size_t kMaxTextBytes = 1000;
// SQLite's own rows, e.g. the schema, may be this large even if tiles may not.
constexpr size_t kMinLengthLimit = size_t{1} << 20;

[[noreturn]] void Refuse(const std::string& what, const std::string& why) {
  throw StorageError(what, why, StorageFault::kDamaged);
}

// The path as SQLite's URI, opened without locks and side files.
std::string ImmutableUri(const std::filesystem::path& file) {
  constexpr char kHexDigits[] = "0123456789ABCDEF";
  std::string uri = "file://";
  for (const char c : std::filesystem::absolute(file).string()) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalnum(byte) != 0 || c == '/' || c == '-' || c == '_' || c == '.') {
      uri += c;
    } else {
      uri += {'%', kHexDigits[byte >> 4U], kHexDigits[byte & 15U]};
    }
  }
  return uri + "?mode=ro&immutable=1";
}

// The views of the file may read and calculate, and nothing else. A recursive one may never end.
int AllowReading(void*, int action, const char*, const char*, const char*, const char*) {
  const bool is_allowed =
      action == SQLITE_SELECT || action == SQLITE_READ || action == SQLITE_FUNCTION;
  return is_allowed ? SQLITE_OK : SQLITE_DENY;
}

// Nothing if the bytes are no picture that every browser shows.
std::optional<std::string> MediaTypeOf(std::string_view bytes) {
  using std::string_view_literals::operator""sv;
  if (bytes.starts_with("\x89PNG\r\n\x1a\n"sv)) return "image/png";
  if (bytes.starts_with("\xff\xd8\xff"sv)) return "image/jpeg";
  const bool is_riff = bytes.size() >= 12 && bytes.starts_with("RIFF"sv);
  if (is_riff && bytes.substr(8, 4) == "WEBP"sv) return "image/webp";
  return std::nullopt;
}

// Vector tiles are gzipped, and protocol buffers whose first field is a layer otherwise.
bool IsVectorTile(std::string_view bytes) {
  return bytes.starts_with("\x1f\x8b") || bytes.starts_with("\x1a");
}

std::optional<double> NumberIn(const std::string& text) {
  if (text.empty()) return std::nullopt;
  char* end = nullptr;
  const double number = std::strtod(text.c_str(), &end);
  if (*end != '\0') return std::nullopt;
  return number;
}

// Reads "8.1,47,8.9,47.5".
std::optional<std::array<double, 4>> BoundsIn(const std::string& text) {
  std::array<double, 4> bounds{};
  size_t begin = 0;
  for (size_t i = 0; i < bounds.size(); ++i) {
    const size_t end = i + 1 < bounds.size() ? text.find(',', begin) : text.size();
    if (end == std::string::npos) return std::nullopt;
    const std::optional<double> number = NumberIn(text.substr(begin, end - begin));
    if (!number) return std::nullopt;
    bounds[i] = *number;
    begin = end + 1;
  }
  const auto& [west, south, east, north] = bounds;
  const bool is_box =
      west >= -180.0 && west < east && east <= 180.0 && south >= -90.0 && south < north;
  if (!is_box || !(north <= 90.0)) return std::nullopt;
  return bounds;
}

std::optional<int> ZoomIn(const std::map<std::string, std::string>& metadata, const char* name) {
  const auto found = metadata.find(name);
  if (found == metadata.end()) return std::nullopt;
  const std::optional<double> number = NumberIn(found->second);
  // The tiles themselves tell it then.
  if (!number || !(*number >= 0.0 && *number <= kMaxZoom)) return std::nullopt;
  return static_cast<int>(*number);
}

}  // namespace

struct MbTiles::State {
  explicit State(const MbTilesOptions& o) : options(o) {}
  ~State() { sqlite3_close(database); }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  void Open(const std::filesystem::path& file);
  void RequireTable(const std::string& name) const;
  std::map<std::string, std::string> ReadMetadata() const;
  int ZoomOf(const char* sql) const;
  MapTile Checked(const Statement& statement, int column) const;
  static int IsOverdue(void* state) {
    return SteadyClock::now() > static_cast<const State*>(state)->deadline ? 1 : 0;
  }

  MbTilesOptions options;
  MbTilesInfo info;
  // Guards the connection and the deadline of its search.
  std::timed_mutex mutex;
  sqlite3* database = nullptr;
  SteadyClock::time_point deadline;
};

void MbTiles::State::Open(const std::filesystem::path& file) {
  std::error_code error;
  // A pipe would keep the server from starting.
  if (!std::filesystem::is_regular_file(file, error)) Refuse("open", "there is no such file");
  // What is still in the log is not in the file, and the file is read alone.
  const auto log_size = std::filesystem::file_size(file.string() + "-wal", error);
  if (!error && log_size > 0) {
    Refuse("open",
           "a write-ahead log lies beside it; close the program that writes it, or run "
           "sqlite3 FILE \"PRAGMA journal_mode=DELETE\"");
  }
  const int flags = SQLITE_OPEN_READONLY | SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX;
  if (sqlite3_open_v2(ImmutableUri(file).c_str(), &database, flags, nullptr) != SQLITE_OK) {
    Refuse("open", "the file cannot be read");
  }
  const size_t length = std::max(options.max_tile_bytes, kMinLengthLimit) + 1;
  sqlite3_limit(database, SQLITE_LIMIT_LENGTH, static_cast<int>(length));
  sqlite3_limit(database, SQLITE_LIMIT_EXPR_DEPTH, 100);
  sqlite3_limit(database, SQLITE_LIMIT_COMPOUND_SELECT, 20);
  sqlite3_limit(database, SQLITE_LIMIT_ATTACHED, 0);
  sqlite3_db_config(database, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  // A file that is cut while it is mapped into memory would end the program.
  for (const char* const pragma : {"PRAGMA trusted_schema = OFF",
                                   "PRAGMA query_only = ON",
                                   "PRAGMA cell_size_check = ON",
                                   "PRAGMA mmap_size = 0"}) {
    Statement(database, pragma).Run();
  }
  sqlite3_set_authorizer(database, &AllowReading, nullptr);
  sqlite3_progress_handler(database, kStepsPerLook, &IsOverdue, this);
}

void MbTiles::State::RequireTable(const std::string& name) const {
  Statement statement(database, "SELECT 1 FROM sqlite_master WHERE name = ?1");
  if (!statement.Bind({name}).Step()) Refuse("MBTiles", "the file has no table " + name);
}

std::map<std::string, std::string> MbTiles::State::ReadMetadata() const {
  std::map<std::string, std::string> metadata;
  Statement statement(database,
                      "SELECT name, value FROM metadata WHERE name IN "
                      "('name', 'format', 'attribution', 'minzoom', 'maxzoom', 'bounds')");
  while (statement.Step()) {
    metadata[statement.Text(0)] = statement.Text(1).substr(0, kMaxTextBytes);
  }
  return metadata;
}

int MbTiles::State::ZoomOf(const char* sql) const {
  Statement statement(database, sql);
  const bool has_row = statement.Step();
  const int64_t zoom = has_row ? statement.Int(0) : -1;
  if (zoom < 0 || zoom > kMaxZoom) Refuse("tiles", "a zoom level is not from 0 to 30");
  return static_cast<int>(zoom);
}

MapTile MbTiles::State::Checked(const Statement& statement, int column) const {
  MapTile tile{statement.Text(column), ""};
  if (tile.bytes.size() > options.max_tile_bytes) {
    Refuse("tile", "it has more than " + std::to_string(options.max_tile_bytes) + " bytes");
  }
  const std::optional<std::string> media_type = MediaTypeOf(tile.bytes);
  if (!media_type && IsVectorTile(tile.bytes)) {
    Refuse("tile", "it is a vector tile; only raster tiles (PNG, JPEG, WebP) can be used");
  }
  if (!media_type) Refuse("tile", "it is not a picture (PNG, JPEG, WebP)");
  tile.media_type = *media_type;
  return tile;
}

MbTiles::MbTiles(const std::filesystem::path& file, const MbTilesOptions& options)
    : state_(std::make_unique<State>(options)) {
  state_->deadline = SteadyClock::now() + options.max_opening;
  state_->Open(file);
  state_->RequireTable("metadata");
  state_->RequireTable("tiles");
  std::map<std::string, std::string> metadata = state_->ReadMetadata();
  if (metadata["format"] == "pbf") {
    Refuse("metadata", "the file holds vector tiles (pbf); only raster tiles can be used");
  }
  {
    Statement first(state_->database, "SELECT tile_data FROM tiles LIMIT 1");
    if (!first.Step()) Refuse("tiles", "the file has no tiles");
    state_->Checked(first, 0);
  }
  MbTilesInfo& info = state_->info;
  info.name = metadata["name"];
  info.attribution = metadata["attribution"];
  info.bounds_deg = BoundsIn(metadata["bounds"]);
  const std::optional<int> min_zoom = ZoomIn(metadata, "minzoom");
  const std::optional<int> max_zoom = ZoomIn(metadata, "maxzoom");
  info.min_zoom = min_zoom ? *min_zoom : state_->ZoomOf("SELECT min(zoom_level) FROM tiles");
  info.max_zoom = max_zoom ? *max_zoom : state_->ZoomOf("SELECT max(zoom_level) FROM tiles");
  if (info.min_zoom > info.max_zoom) {
    info.min_zoom = state_->ZoomOf("SELECT min(zoom_level) FROM tiles");
    info.max_zoom = state_->ZoomOf("SELECT max(zoom_level) FROM tiles");
  }
}

MbTiles::~MbTiles() = default;

const MbTilesInfo& MbTiles::info() const { return state_->info; }

std::optional<MapTile> MbTiles::Find(int zoom, int64_t x, int64_t y) const {
  if (zoom < 0 || zoom > kMaxZoom) return std::nullopt;
  const int64_t num_rows = int64_t{1} << zoom;
  if (x < 0 || x >= num_rows || y < 0 || y >= num_rows) return std::nullopt;
  const std::unique_lock lock(state_->mutex, state_->options.max_search);
  if (!lock) throw StorageError("tile", "other searches take too long");
  state_->deadline = SteadyClock::now() + state_->options.max_search;
  Statement statement(state_->database,
                      "SELECT tile_data FROM tiles "
                      "WHERE zoom_level = ?1 AND tile_column = ?2 AND tile_row = ?3");
  if (!statement.Bind({zoom, x, num_rows - 1 - y}).Step()) return std::nullopt;
  return state_->Checked(statement, 0);
}

}  // namespace freelsd
