// SQL for rows of sites, on a connection to the main database or to the second copy of the sites.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "storage/box_cache.h"
#include "storage/site_store.h"
#include "storage/sqlite/sqlite.h"

namespace freelsd {

// Writes the rows of one site to one database, within the caller's transaction.
void PutSiteRows(const Connection& writer, const SiteRow& site);

// Rows have neither recall nor map_box. Throws StorageError kDamaged if a checksum is wrong.
std::optional<SiteRow> FindSiteRow(const Connection& connection, const std::string& site_id);
// With recall, map_box and map_datum.
std::optional<SiteRow> FindWholeSiteRow(const Connection& connection, const std::string& site_id);
std::vector<SiteRow> ListSiteRows(const Connection& connection,
                                  const std::optional<std::string>& flight_id,
                                  const std::optional<BoundingBox>& box);
// Calls `visit` for each row whose box in site_boxes meets `box`, which may cross the antimeridian.
// `select` ends with conditions and AND.
void ForEachMeeting(const Connection& connection,
                    const std::string& select,
                    const BoundingBox& box,
                    const std::function<void(const Statement&)>& visit);
// The box must not cross the antimeridian.
BoxCache<RecallRow>::Rows ListRecallRows(const Connection& connection, const BoundingBox& box);

// Also deletes the site's R*Tree row, because an R*Tree has no foreign keys. True if the site
// existed.
bool DeleteSiteRows(const Connection& writer, const std::string& site_id);

// Reads all rows once. Throws StorageError kDamaged if a checksum is wrong or a site has no box.
void CheckSiteRows(const Connection& connection);

// Values by which two copies of a site are compared.
struct SiteStamp {
  int64_t updated_at_us = 0;
  Standing standing;

  bool operator==(const SiteStamp&) const = default;
};
using SiteStamps = std::map<std::string, SiteStamp>;
SiteStamps StampsOf(const Connection& connection);

}  // namespace freelsd
