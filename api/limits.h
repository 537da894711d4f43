// Every limit on incoming data.
#pragma once

#include <cstddef>
#include <cstdint>

namespace freelsd {

// Input beyond a limit causes ApiError ImageTooLarge, ZipTooLarge, PosesTooLarge, InvalidJson,
// InvalidValue or InvalidPoses.
struct ImageLimits {
  // A decoded image takes 3 bytes per pixel: 192 MiB at this limit.
  double max_megapixels = 64.0;
  // No aerial camera with that many pixels has longer sides.
  int max_side_px = 16384;
  // The encoded image is held in memory as a whole.
  size_t max_bytes = 32u << 20;
};

struct ZipLimits {
  // Far more images than one flight has; every entry's name is held in memory.
  int max_entries = 20000;
  // Unpacked over packed bytes. Images and text stay far below; zip bombs lie far above.
  double max_ratio = 200.0;
  // The entries are processed one by one, but all of them are stored on disk.
  uint64_t max_total_bytes = uint64_t{16} << 30;
  // An entry is held in memory as a whole.
  uint64_t max_entry_bytes = uint64_t{64} << 20;
};

struct JsonLimits {
  // The parsed form takes many times the size of the text.
  size_t max_bytes = size_t{1} << 20;
  // The contract nests far less. The JSON library's destructor and dump() recurse.
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
  // Photographs have a few dozen. A hostile file may consist of tiny segments only.
  size_t max_num_segments = 4096;
  // XMP packets nest about 5 levels deep. The XMP library recurses.
  int max_xmp_depth = 32;
  // Components read from one tag. GPS tags have 3; components beyond the limit are ignored.
  long max_num_components = 16;
  size_t max_text_bytes = 1024;
};

struct Limits {
  ImageLimits image;
  ZipLimits zip;
  JsonLimits json;
  PoseLimits poses;
  TagLimits tags;
  // Ids are parts of file names and URLs.
  size_t max_id_bytes = 128;
  // A flight's name, which is shown on one line.
  size_t max_name_bytes = 256;
  // Cells of a stored map: the engine's default limit for a map.
  uint64_t max_num_map_cells = 25'000'000;
};

// The limits in force.
inline constexpr Limits kLimits{};

}  // namespace freelsd
