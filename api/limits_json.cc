#include <nlohmann/json.hpp>

#include "api/api.h"

namespace freelsd {

nlohmann::json LimitsJson(const Limits& limits) {
  return {{"max_json_bytes", limits.json.max_bytes},
          {"max_json_depth", limits.json.max_depth},
          {"max_id_bytes", limits.max_id_bytes},
          {"max_name_bytes", limits.max_name_bytes},
          {"max_image_megapixels", limits.image.max_megapixels},
          {"max_image_side_px", limits.image.max_side_px},
          {"max_image_bytes", limits.image.max_bytes},
          {"max_tag_block_bytes", limits.tags.max_block_bytes},
          {"max_tag_text_bytes", limits.tags.max_text_bytes},
          {"max_num_tag_components", limits.tags.max_num_components},
          {"max_num_tag_segments", limits.tags.max_num_segments},
          {"max_xmp_depth", limits.tags.max_xmp_depth},
          {"max_num_zip_entries", limits.zip.max_entries},
          {"max_zip_ratio", limits.zip.max_ratio},
          {"max_zip_entry_bytes", limits.zip.max_entry_bytes},
          {"max_zip_total_bytes", limits.zip.max_total_bytes},
          {"max_pose_file_bytes", limits.poses.max_file_bytes},
          {"max_pose_header_bytes", limits.poses.max_header_bytes},
          {"max_num_pose_columns", limits.poses.max_num_columns},
          {"max_yaml_bytes", limits.poses.max_yaml_bytes},
          {"max_yaml_depth", limits.poses.max_yaml_depth},
          {"max_num_map_cells", limits.max_num_map_cells}};
}

}  // namespace freelsd
