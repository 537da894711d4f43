#include "storage/postgres/area_rows.h"

#include <vector>

#include "storage/boxes.h"

namespace freelsd {
namespace {

// Columns of boxes, to be unnested.
struct Edges {
  explicit Edges(const std::vector<BoundingBox>& boxes) {
    for (const BoundingBox& box : boxes) {
      west_deg.push_back(box.west_deg);
      south_deg.push_back(box.south_deg);
      east_deg.push_back(box.east_deg);
      north_deg.push_back(box.north_deg);
    }
  }

  std::vector<double> west_deg, south_deg, east_deg, north_deg;
};

constexpr char kBoxes[] =
    "unnest($1::float8[], $2::float8[], $3::float8[], $4::float8[]) WITH ORDINALITY "
    "AS box (west_deg, south_deg, east_deg, north_deg, part)";
constexpr char kEnvelope[] = "ST_MakeEnvelope(west_deg, south_deg, east_deg, north_deg, 4326)";

}  // namespace

void PutArea(PostgresConnection& writer,
             const std::string& table,
             const std::string& id,
             const BoundingBox& box) {
  const Edges edges(PlainBoxes(Unrolled(box)));
  writer.Run("DELETE FROM " + table + "_areas WHERE " + table + "_id = $1", id);
  writer.Run("INSERT INTO " + table + "_areas (" + table + "_id, part, area) SELECT $5, part, " +
                 kEnvelope + " FROM " + kBoxes,
             edges.west_deg,
             edges.south_deg,
             edges.east_deg,
             edges.north_deg,
             id);
}

PostgresRows SelectMeeting(PostgresConnection& connection,
                           const std::string& select,
                           const std::string& table,
                           const BoundingBox& box) {
  const Edges edges(TouchingBoxes(box));
  return connection.Run(select + " (SELECT " + table + "_id FROM " + kBoxes + " JOIN " + table +
                            "_areas ON area && " + kEnvelope + ")",
                        edges.west_deg,
                        edges.south_deg,
                        edges.east_deg,
                        edges.north_deg);
}

}  // namespace freelsd
