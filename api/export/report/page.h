// Private to report/. Parts of HTML that the reports share. Arguments are HTML unless they say
// otherwise.
#pragma once

#include <string>
#include <vector>

#include "api/stored/stored.h"

namespace freelsd {

// The whole page. `title` is plain text; `more_style` is added to the common style.
std::string PageOf(const std::string& title,
                   const std::string& more_style,
                   const std::string& body);

// A line of a table: its label and its value.
std::string Row(const std::string& label, const std::string& value);
std::string Table(const std::string& rows);
// A table with a head; `rows` have as many cells as the head.
std::string ColumnTable(const std::vector<std::string>& head,
                        const std::vector<std::vector<std::string>>& rows);

// "landable", "unverified" or "rejected".
std::string VerdictOf(const StoredSite& site);
std::string VerdictBox(const StoredSite& site);
// The lines of a site's numbers, for Table.
std::string SiteRows(const StoredSite& site);
// Latitude and longitude.
std::string PlaceText(const GeoPoint& place);
// "from 245&#176; true at 4.3 m/s": where the wind comes from, as pilots say it.
std::string WindText(double east_mps, double north_mps);
// "2026-05-01 10:00 UTC" of an RFC 3339 time in UTC; escaped.
std::string TimeText(const std::string& rfc3339);
std::string StripText(const StoredSite& site);
std::string DatumSentence(const std::string& datum);

}  // namespace freelsd
