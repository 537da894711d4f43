#include "storage/sqlite/site_standings.h"

namespace freelsd {

Standing StandingAt(const Statement& statement, int first_column) {
  Standing standing;
  if (std::string id = statement.Text(first_column); !id.empty()) {
    standing.superseded_by = std::move(id);
  }
  standing.superseded_at_us = statement.Int(first_column + 1);
  standing.superseded_reason = statement.Text(first_column + 2);
  standing.superseded_detail = statement.Text(first_column + 3);
  standing.confirmed_at_us = statement.OptionalInt(first_column + 4);
  standing.is_checked = statement.Int(first_column + 5) != 0;
  standing.superseded_by_map = statement.Text(first_column + 6);
  return standing;
}

void PutStandings(const Connection& writer, const Standings& standings) {
  for (const auto& [id, standing] : standings) {
    writer
        .Prepare(
            "UPDATE sites SET superseded_by = nullif(?2, ''), superseded_at_us = nullif(?3, 0), "
            "superseded_reason = ?4, superseded_detail = ?5, confirmed_at_us = nullif(?6, 0), "
            "is_checked = ?7, superseded_by_map = ?8 WHERE id = ?1")
        .Bind(id,
              standing.superseded_by.value_or(""),
              standing.superseded_at_us,
              standing.superseded_reason,
              standing.superseded_detail,
              standing.confirmed_at_us.value_or(0),
              static_cast<int>(standing.is_checked),
              standing.superseded_by_map)
        .Run();
  }
}

}  // namespace freelsd
