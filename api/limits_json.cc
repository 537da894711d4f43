#include <nlohmann/json.hpp>

#include "api/api.h"

namespace freelsd {
namespace {

nlohmann::json ObstacleLimitsJson(const ObstacleLimits& limits) {
  return {{"max_obstacle_bytes", limits.max_bytes},
          {"max_obstacle_import_bytes", limits.max_import_bytes},
          {"max_num_obstacle_points", limits.max_num_points},
          {"max_num_obstacles", limits.max_num_stored},
          {"max_obstacle_leg_m", limits.max_leg_m},
          {"max_airspace_leg_m", limits.max_airspace_leg_m}};
}

nlohmann::json LinkLimitsJson(const LinkLimits& limits) {
  return {{"max_num_links", limits.max_num_links},
          {"max_link_bytes", limits.max_bytes},
          {"max_link_text_bytes", limits.max_text_bytes},
          {"max_num_link_decisions", limits.max_num_decisions},
          {"max_num_reported_commands", limits.max_num_reported_commands},
          {"max_num_queued_commands", limits.max_num_queued_commands},
          {"max_num_commands", limits.max_num_commands}};
}

nlohmann::json LongQueuesJson(const ConcurrencyLimits& limits) {
  return {{"max_num_rose_planners", limits.plans.max_num_computing},
          {"max_num_waiting_plans", limits.plans.max_num_waiting},
          {"max_num_reach_planners", limits.reach.max_num_computing},
          {"max_num_waiting_reaches", limits.reach.max_num_waiting},
          {"max_num_route_planners", limits.routes.max_num_computing},
          {"max_num_waiting_routes", limits.routes.max_num_waiting},
          {"max_num_file_writers", limits.files.max_num_computing},
          {"max_num_waiting_files", limits.files.max_num_waiting}};
}

// Images, their tags, archives and pose files.
nlohmann::json FileLimitsJson(const Limits& limits) {
  return {{"max_image_megapixels", limits.image.max_megapixels},
          {"max_image_side_px", limits.image.max_side_px},
          {"max_image_bytes", limits.image.max_bytes},
          {"max_tag_block_bytes", limits.tags.max_block_bytes},
          {"max_tag_text_bytes", limits.tags.max_text_bytes},
          {"max_num_tag_components", limits.tags.max_num_components},
          {"max_num_tag_segments", limits.tags.max_num_segments},
          {"max_num_zip_entries", limits.zip.max_entries},
          {"max_zip_ratio", limits.zip.max_ratio},
          {"max_zip_entry_bytes", limits.zip.max_entry_bytes},
          {"max_zip_total_bytes", limits.zip.max_total_bytes},
          {"max_pose_file_bytes", limits.poses.max_file_bytes},
          {"max_pose_header_bytes", limits.poses.max_header_bytes},
          {"max_num_pose_columns", limits.poses.max_num_columns},
          {"max_yaml_bytes", limits.poses.max_yaml_bytes},
          {"max_yaml_depth", limits.poses.max_yaml_depth}};
}

}  // namespace

nlohmann::json LimitsJson(const Limits& limits) {
  nlohmann::json object{
      {"max_head_bytes", limits.head.max_bytes},
      {"max_num_head_lines", limits.head.max_num_lines},
      {"max_head_line_bytes", limits.head.max_line_bytes},
      {"max_url_bytes", limits.head.max_target_bytes},
      {"max_num_connections", limits.connection.max_num_connections},
      {"max_num_connections_of_address", limits.connection.max_num_connections_of_address},
      {"max_request_ms", limits.connection.max_request_ms},
      {"max_small_body_bytes", limits.connection.max_small_body_bytes},
      {"max_num_large_bodies", limits.connection.max_num_large_bodies},
      {"max_idle_s", limits.connection.max_idle_s},
      {"max_write_pause_s", limits.connection.max_write_pause_s},
      {"max_unsent_bytes", limits.connection.max_unsent_bytes},
      {"max_num_event_clients", limits.events.max_num_clients},
      {"max_event_bytes", limits.events.max_event_bytes},
      {"max_unsent_event_bytes", limits.events.max_unsent_bytes},
      {"max_event_log_bytes", limits.events.max_log_bytes},
      {"max_json_bytes", limits.json.max_bytes},
      {"max_json_depth", limits.json.max_depth},
      {"max_id_bytes", limits.max_id_bytes},
      {"max_name_bytes", limits.max_name_bytes},
      {"max_frame_meta_bytes", limits.max_frame_meta_bytes},
      {"max_emergency_bytes", limits.max_emergency_bytes},
      {"max_num_batch_images", limits.batch.max_num_images},
      {"max_num_side_files", limits.batch.max_num_side_files},
      {"max_total_side_file_bytes", limits.batch.max_total_side_file_bytes},
      {"max_frame_stream_bytes", limits.stream.max_frame_stream_bytes},
      {"max_telemetry_bytes", limits.stream.max_telemetry_bytes},
      {"max_telemetry_line_bytes", limits.stream.max_telemetry_line_bytes},
      {"max_stream_pause_s", limits.stream.max_pause_s},
      {"max_num_uploads", limits.concurrency.max_num_uploads},
      {"max_num_streams", limits.concurrency.max_num_streams},
      {"max_num_decoders", limits.concurrency.max_num_decoders},
      {"max_num_listed", limits.answer.max_num_listed},
      {"max_num_listed_sites", limits.answer.max_num_listed},
      {"max_list_bytes", limits.answer.max_list_bytes},
      {"max_num_exported_sites", limits.answer.max_num_exported_sites},
      {"max_num_emergency_sites", limits.answer.max_num_emergency_sites},
      {"max_num_reach_vertices", limits.answer.max_num_reach_vertices},
      {"max_num_reach_maps", limits.answer.max_num_reach_maps},
      {"max_reach_work", limits.answer.max_reach_work},
      {"max_num_alternates", limits.answer.max_num_alternates},
      {"max_num_rose_winds", limits.answer.max_num_rose_winds},
      {"max_num_track_positions", limits.answer.max_num_track_positions},
      {"max_num_listed_errors", limits.answer.max_num_listed_errors},
      {"max_num_listed_rejections", limits.answer.max_num_listed_rejections},
      {"max_num_map_cells", limits.max_num_map_cells},
      {"max_changes_bytes", limits.following.max_changes_bytes},
      {"max_map_bytes", limits.following.max_map_bytes},
      {"max_base_map_tile_bytes", limits.base_map.max_tile_bytes}};
  object.update(LongQueuesJson(limits.concurrency));
  object.update(FileLimitsJson(limits));
  object.update(ObstacleLimitsJson(limits.obstacles));
  object.update(LinkLimitsJson(limits.links));
  return object;
}

}  // namespace freelsd
