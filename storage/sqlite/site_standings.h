// SQL for the columns of Standing.
#pragma once

#include "storage/site_store.h"
#include "storage/sqlite/sqlite.h"

namespace freelsd {

// The columns, in the order in which StandingAt reads them.
constexpr char kStandingColumns[] =
    "superseded_by, superseded_at_us, superseded_reason, superseded_detail, confirmed_at_us, "
    "is_checked, superseded_by_map";

Standing StandingAt(const Statement& statement, int first_column);
// Writes standings within the caller's transaction. Ids without a site are ignored.
void PutStandings(const Connection& writer, const Standings& standings);

}  // namespace freelsd
