// Rows of sites, on one connection: the database's, or that of their second copy.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "storage/box_cache.h"
#include "storage/sqlite.h"
#include "storage/storage.h"

namespace freelsd {

// One box, or the two halves of one that crosses the antimeridian.
std::vector<BoundingBox> PlainBoxes(const BoundingBox& box);

// Within a transaction of the caller; as Storage::PutSite.
void PutSiteRows(const Connection& writer,
                 const SiteRow& site,
                 std::string_view map_blob,
                 const std::vector<std::string>& supersedes);

// All but recall and map_box; throws StorageError kDamaged where a row is not what was written.
std::optional<SiteRow> FindSiteRow(const Connection& connection, const std::string& site_id);
std::vector<SiteRow> ListSiteRows(const Connection& connection,
                                  const std::optional<std::string>& flight_id,
                                  const std::optional<BoundingBox>& box);
std::optional<std::string> ReadMapBlob(const Connection& connection, const std::string& site_id);
// Both for a box that does not cross the antimeridian.
BoxCache<RecallRow>::Rows ListRecallRows(const Connection& connection, const BoundingBox& box);
BoxCache<Storage::MapRow>::Rows ListMapRows(const Connection& connection, const BoundingBox& box);

// Whether it was there. An R*Tree takes no foreign key, so its row is deleted here too.
bool DeleteSiteRows(const Connection& writer, const std::string& site_id);
void DeleteSiteRowsOf(const Connection& writer, const std::string& flight_id);

// All rows once; throws StorageError kDamaged where one is not what was written or lacks its place.
void CheckSiteRows(const Connection& connection);

// By id: when it was written and what superseded it.
using SiteStamps = std::map<std::string, std::tuple<int64_t, std::string>>;
SiteStamps StampsOf(const Connection& connection);
// Changes `to` so that it has the sites that `from` has.
void CopySites(const Connection& from, const Connection& to);

}  // namespace freelsd
