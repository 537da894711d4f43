#include "storage/move/move.h"

namespace freelsd {
namespace {

using enum ColumnKind;

MovedTable Plain(const std::string& name,
                 std::vector<MovedColumn> columns,
                 const std::string& order) {
  const std::string from = " FROM " + name + " ORDER BY " + order;
  return {name, std::move(columns), from, from};
}

// Flights have no column for the order of their creation in SQLite.
MovedTable Flights() {
  MovedTable table = Plain("flights",
                           {{"id", kText},
                            {"name", kText},
                            {"request_json", kText},
                            {"rig_json", kText},
                            {"warnings_json", kText},
                            {"stages_json", kText},
                            {"created_at_us", kInt},
                            {"num_rejected_frames", kInt},
                            {"has_failed", kBool},
                            {"ground_altitude_m", kOptionalReal},
                            {"has_retired_images", kBool}},
                           "number");
  table.from_sqlite = " FROM flights ORDER BY rowid";
  return table;
}

MovedTable Frames() {
  return Plain("frames",
               {{"flight_id", kText},
                {"sequence", kInt},
                {"id", kText},
                {"sha256", kText},
                {"meta_json", kText},
                {"state", kInt},
                {"reason", kText},
                {"is_from_batch", kBool},
                {"tags_json", kText},
                {"resolved_json", kText},
                {"arrived_at_us", kInt}},
               "flight_id, sequence");
}

MovedTable Telemetry() {
  return Plain("telemetry",
               {{"flight_id", kText},
                {"kind", kInt},
                {"timestamp_us", kInt},
                {"value_0", kReal},
                {"value_1", kReal},
                {"value_2", kReal},
                {"value_3", kReal},
                {"arrived_at_us", kInt}},
               "flight_id, kind, timestamp_us");
}

MovedTable Jobs() {
  return Plain("jobs",
               {{"number", kInt},
                {"id", kText},
                {"kind", kText},
                {"flight_id", kText},
                {"state", kInt},
                {"progress_ratio", kReal},
                {"stage", kText},
                {"detail_json", kText},
                {"created_at_us", kInt}},
               "number");
}

MovedTable Regions() {
  return Plain("regions",
               {{"flight_id", kText},
                {"id", kInt},
                {"rank", kInt},
                {"feature_json", kText},
                {"history_json", kText}},
               "flight_id, id");
}

// An unfinished map is made anew.
MovedTable Maps() {
  MovedTable table = Plain("maps",
                           {{"id", kText},
                            {"flight_id", kText},
                            {"head_json", kText},
                            {"altitude_datum", kText},
                            {"west_deg", kReal},
                            {"south_deg", kReal},
                            {"east_deg", kReal},
                            {"north_deg", kReal},
                            {"updated_at_us", kInt},
                            {"seen_at_us", kInt},
                            {"coalesce(seen_until_us, 0)", kInt}},
                           "id");
  table.from_postgres = " FROM maps WHERE is_in_force ORDER BY id";
  table.from_sqlite = " FROM maps WHERE is_in_force = 1 ORDER BY id";
  return table;
}

MovedTable TilesOf(const std::string& name, const MovedColumn& content) {
  MovedTable table =
      Plain(name,
            {{"map_id", kText}, {"level", kInt}, {"row", kInt}, {"col", kInt}, content},
            "map_id, level, row, col");
  const std::string key = " ORDER BY map_id, level, row, col";
  table.from_postgres =
      " FROM " + name + " WHERE map_id IN (SELECT id FROM maps WHERE is_in_force)" + key;
  table.from_sqlite =
      " FROM " + name + " WHERE map_id IN (SELECT id FROM maps WHERE is_in_force = 1)" + key;
  return table;
}

// SQLite keeps boxes as 32-bit numbers, rounded outwards.
MovedTable Sites() {
  MovedTable table = Plain("sites",
                           {{"id", kText},
                            {"flight_id", kText},
                            {"region_id", kInt},
                            {"map_id", kText},
                            {"latitude_deg", kReal},
                            {"longitude_deg", kReal},
                            {"feature_json", kText},
                            {"approach_json", kText},
                            {"replan_json", kText},
                            {"updated_at_us", kInt},
                            {"seen_at_us", kInt},
                            {"coalesce(seen_until_us, 0)", kInt},
                            {"coalesce(superseded_by, '')", kText},
                            {"superseded_by_map", kText},
                            {"coalesce(superseded_at_us, 0)", kInt},
                            {"superseded_reason", kText},
                            {"superseded_detail", kText},
                            {"coalesce(confirmed_at_us, 0)", kInt},
                            {"is_checked", kBool},
                            {"is_recallable", kBool},
                            {"is_landable", kBool},
                            {"altitude_m", kReal},
                            {"altitude_datum", kText},
                            {"score", kReal},
                            {"aircraft_json", kText},
                            {"west_deg", kReal, false},
                            {"south_deg", kReal, false},
                            {"east_deg", kReal, false},
                            {"north_deg", kReal, false}},
                           "id");
  table.from_sqlite =
      " FROM sites JOIN site_numbers ON site_id = id JOIN site_boxes USING (number) ORDER BY id";
  return table;
}

MovedTable Obstacles() {
  return Plain("obstacles",
               {{"id", kText},
                {"feature_json", kText},
                {"west_deg", kReal},
                {"south_deg", kReal},
                {"east_deg", kReal},
                {"north_deg", kReal},
                {"coalesce(expires_at_us, 0)", kInt},
                {"updated_at_us", kInt}},
               "id");
}

}  // namespace

const std::vector<MovedTable>& MovedTables() {
  static const std::vector<MovedTable> kTables{Flights(),
                                               Frames(),
                                               Telemetry(),
                                               Jobs(),
                                               Regions(),
                                               Maps(),
                                               TilesOf("map_tiles", {"tile", kBytes}),
                                               TilesOf("photo_tiles", {"sha256", kText}),
                                               Sites(),
                                               Obstacles()};
  return kTables;
}

std::string ColumnList(const MovedTable& table) {
  std::string list;
  for (const MovedColumn& column : table.columns) {
    list += (list.empty() ? "" : ", ") + column.name;
  }
  return list;
}

}  // namespace freelsd
