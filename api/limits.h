// Every fixed limit on requests and answers. Settings for the operator are in server/config.h.
#pragma once

#include <cstddef>
#include <cstdint>

namespace freelsd {

// Input beyond a limit causes ApiError ImageTooLarge, ZipTooLarge, PosesTooLarge, InvalidJson,
// InvalidValue or InvalidPoses.
struct ImageLimits {
  // A decoded image takes 3 bytes per pixel: 192 MiB at this limit.
  double max_megapixels = 64.0;
  // No aerial camera with max_megapixels has a longer side.
  int max_side_px = 16384;
  // The encoded image is held in memory as a whole.
  size_t max_bytes = 32u << 20;
};

struct ZipLimits {
  // A flight has far fewer images. The name of every entry is held in memory.
  int max_entries = 20000;
  // Ratio of unpacked to packed bytes. Images and text stay far below it. Zip bombs exceed it by
  // far.
  double max_ratio = 200.0;
  // The entries are processed one by one, but all of them are stored on disk.
  uint64_t max_total_bytes = uint64_t{16} << 30;
  // An entry is held in memory as a whole.
  uint64_t max_entry_bytes = uint64_t{64} << 20;
};

struct JsonLimits {
  // The parsed form takes many times the size of the text.
  size_t max_bytes = size_t{1} << 20;
  // Valid requests nest far less. The JSON library's destructor and dump() recurse.
  int max_depth = 32;
};

struct PoseLimits {
  // A file is held in memory as a whole. COLMAP files are large: they list every observation.
  size_t max_file_bytes = size_t{64} << 20;
  // Every cell of every line becomes a string.
  size_t max_num_columns = 256;
  // The header line is read before the separator is detected.
  size_t max_header_bytes = size_t{64} << 10;
  // Calibrations have a few kB. The parsed form takes many times the size of the text.
  size_t max_yaml_bytes = size_t{64} << 10;
  // Calibrations nest 3 levels deep. The parser recurses.
  int max_yaml_depth = 16;
};

// Tags beyond these limits count as absent. They never cause an error because tags are optional.
struct TagLimits {
  // A JPEG segment holds 64 KiB; a PNG chunk could hold anything.
  size_t max_block_bytes = size_t{256} << 10;
  // Photographs have a few dozen segments. A hostile file may consist only of tiny segments.
  size_t max_num_segments = 4096;
  // Components read from one tag. GPS tags have 3. Components beyond the limit are ignored.
  long max_num_components = 16;
  size_t max_text_bytes = 1024;
};

// The head of a request: request line and headers.
struct HeadLimits {
  size_t max_bytes = 16 << 10;
  size_t max_num_lines = 64;
  size_t max_line_bytes = 4 << 10;
  size_t max_target_bytes = 2 << 10;
};

// Connections of one listener. A poll loop waits for heads, small bodies and slow readers, so that
// these hold no thread.
struct ConnectionLimits {
  // If this number is reached, a new connection replaces another one, preferably the one that has
  // been idle for longest.
  size_t max_num_connections = 1000;
  // The same for the connections of one address; the others keep room for other addresses.
  size_t max_num_connections_of_address = 500;
  // A head, and a body up to max_small_body_bytes, must arrive whole within this time.
  int max_request_ms = 1000;
  size_t max_small_body_bytes = size_t{64} << 10;
  // Each larger or chunked body has a thread of its own. If there are more such bodies, the answer
  // is 429. The emergency listener accepts no such body.
  int max_num_large_bodies = 24;
  int max_idle_s = 60;
  // A client that reads nothing of its answer for that long is disconnected.
  int max_write_pause_s = 10;
  // Total size of the answers that clients have not read yet. If it is exceeded, the answer that
  // waits longest is dropped.
  size_t max_unsent_bytes = size_t{256} << 20;
};

// Server-Sent Events.
struct EventLimits {
  int max_num_clients = 100;
  // A larger event is sent as "resync": the client fetches the state.
  size_t max_event_bytes = size_t{256} << 10;
  // Text that waits in memory for one client. Events beyond it wait in the log.
  size_t max_unsent_bytes = size_t{256} << 10;
  // Total size of the events that are kept for slow and for returning clients.
  size_t max_log_bytes = size_t{8} << 20;
};

struct BatchLimits {
  size_t max_num_images = 20000;
  // Pose files, calibrations and other files beside the images. All are held in memory together.
  size_t max_num_side_files = 64;
  size_t max_total_side_file_bytes = size_t{128} << 20;
};

// Requests that last as long as a flight.
struct StreamLimits {
  uint64_t max_frame_stream_bytes = uint64_t{1} << 40;
  uint64_t max_telemetry_bytes = uint64_t{2} << 30;
  // A longer line is rejected, and the stream continues.
  size_t max_telemetry_line_bytes = 8 << 10;
  // A stream ends if it sends nothing for this time.
  int max_pause_s = 60;
};

// Requests of one kind that compute for long. One beyond both limits is answered with 429.
struct LongQueueLimits {
  int max_num_computing = 1;
  // Each holds a thread.
  int max_num_waiting = 4;
};

// Largest numbers of requests of one kind that are served at the same time. A request beyond a
// limit is answered with 429. Exception: requests that need a decoder wait.
struct ConcurrencyLimits {
  // Each upload holds an encoded image in memory, and a thread.
  int max_num_uploads = 8;
  // Each stream holds a thread for as long as the flight.
  int max_num_streams = 8;
  // Images decoded at the same time: 64 megapixels take 192 MiB.
  int max_num_decoders = 2;
  // Wind roses take seconds. The page asks for six answers at once.
  LongQueueLimits plans{2, 12};
  // The ground in reach takes up to a second, and megabytes of memory.
  LongQueueLimits reach{1, 4};
  // The insurance of a route takes a second of all processors.
  LongQueueLimits routes{1, 4};
  // Reports and files of whole maps take seconds.
  LongQueueLimits files{1, 6};
};

// Length of answers.
struct AnswerLimits {
  // Flights, jobs or sites of one page.
  size_t max_num_listed = 10000;
  // Total size of the jobs on one page. A longer page ends early. A job can be large, because it
  // lists the result of each image.
  size_t max_list_bytes = size_t{32} << 20;
  size_t max_num_exported_sites = 1000;
  size_t max_num_emergency_sites = 50;
  // Of the polygons of one answer of reach, and stored maps that it reads.
  size_t max_num_reach_vertices = 4000;
  size_t max_num_reach_maps = 200;
  // Steps of one answer of reach (ReachLimits::max_work): about a second (0047). Beyond them, its
  // cells are larger.
  double max_reach_work = 60e6;
  // Sites that a flight's list of alternates may have.
  size_t max_num_alternates = 20;
  // Planning for one wind takes 0.2 ms over an open field, and 20 ms if most of the field is
  // obstructed.
  size_t max_num_rose_winds = 180;
  // Enough for a line on a map. Longer tracks are thinned.
  int64_t max_num_track_positions = 2000;
  // Errors of a batch or pose file.
  size_t max_num_listed_errors = 20;
  // Rejected frames or lines of a stream. All of them are counted, but only these are listed.
  size_t max_num_listed_rejections = 100;
};

// Obstacles that photographs do not show.
struct ObstacleLimits {
  // The body of one obstacle, and of an import of many.
  size_t max_bytes = size_t{256} << 10;
  size_t max_import_bytes = size_t{8} << 20;
  // Positions of one line or ring.
  size_t max_num_points = 1000;
  // All stored ones are held in memory, and each recall looks at all of them.
  size_t max_num_stored = 20000;
  // Between two positions of a line or ring. A map's plane lies 50 m beside the ground at the ends
  // of a leg twice as long.
  double max_leg_m = 50000.0;
  // The same for an airspace, which is held against places on the ellipsoid.
  double max_airspace_leg_m = 500000.0;
};

// Planned flights whose landing insurance is asked for.
struct RouteLimits {
  // Plans of large surveys have thousands of items.
  size_t max_bytes = size_t{4} << 20;
  size_t max_num_points = 2000;
  size_t max_num_winds = 24;
  // Moments times winds: a recall for each takes about a millisecond.
  size_t max_num_recalls = 30000;
};

// Servers that follow this one.
struct FollowingLimits {
  // What a follower sends back at once.
  size_t max_changes_bytes = size_t{64} << 20;
  // One map of a flight.
  size_t max_map_bytes = size_t{512} << 20;
};

// Links to autopilots. All they report is held in memory.
struct LinkLimits {
  size_t max_num_links = 100;
  size_t max_bytes = size_t{64} << 10;
  size_t max_text_bytes = 1000;
  // Of one report.
  size_t max_num_decisions = 100;
  size_t max_num_reported_commands = 200;
  // Commands of one link that wait to be handed over, and those whose outcome is remembered.
  size_t max_num_queued_commands = 8;
  size_t max_num_commands = 50;
};

// The operator's base map.
struct BaseMapLimits {
  size_t max_tile_bytes = size_t{2} << 20;
  int max_zoom = 24;
  size_t max_url_bytes = 1000;
};

struct Limits {
  HeadLimits head;
  ConnectionLimits connection;
  EventLimits events;
  ImageLimits image;
  ZipLimits zip;
  JsonLimits json;
  PoseLimits poses;
  TagLimits tags;
  BatchLimits batch;
  StreamLimits stream;
  ConcurrencyLimits concurrency;
  AnswerLimits answer;
  ObstacleLimits obstacles;
  RouteLimits routes;
  BaseMapLimits base_map;
  LinkLimits links;
  FollowingLimits following;
  // The metadata part sent with one image, also in a stream.
  size_t max_frame_meta_bytes = size_t{64} << 10;
  // The body of an emergency request.
  size_t max_emergency_bytes = size_t{64} << 10;
  // Ids are parts of file names and URLs.
  size_t max_id_bytes = 128;
  // A flight's name, which is shown on one line.
  size_t max_name_bytes = 256;
  // Cells of a stored map; equals the engine's default for max_num_cells.
  uint64_t max_num_map_cells = 25'000'000;
};

// The limits in force.
inline constexpr Limits kLimits{};

}  // namespace freelsd
