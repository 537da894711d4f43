// SQL for rows of sites, in the main database or in the second copy.
#pragma once

#include <optional>
#include <string>

#include "storage/stores/stores.h"

namespace freelsd {

extern const SiteQueries kSqliteSites;

// Writes the rows of one site to one database, within the caller's transaction.
void PutSiteRows(Database& writer, const SiteRow& site);
// With recall, map_box and map_datum. Throws StorageError kDamaged if a checksum is wrong.
std::optional<SiteRow> FindWholeSiteRow(Database& database, const std::string& site_id);
// True if the site existed.
bool DeleteSiteRows(Database& writer, const std::string& site_id);
// Reads all rows once. Throws StorageError kDamaged if a checksum is wrong or a site has no box.
void CheckSiteRows(Database& database);

}  // namespace freelsd
