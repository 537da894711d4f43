// SeeYou CUP: landables for gliding computers. Minutes have three decimals because older readers
// accept no others. A position is exact to 1.4 m; the description has all decimals.
#include <algorithm>
#include <cctype>
#include <cmath>

#include "api/export/sites/site_export.h"

namespace freelsd {
namespace {

// "Outlanding" in the format's list of styles.
constexpr int kOutlanding = 3;
constexpr long kThousandthsPerDegree = 60000;

// DDMM.mmmN, DDDMM.mmmE. Rounded to thousandths of a minute first, so that 59.9996' carries over.
std::string Angle(double degrees, int num_degree_digits, const char* signs) {
  const long thousandths =
      std::lround(std::abs(degrees) * static_cast<double>(kThousandthsPerDegree));
  const long rest = thousandths % kThousandthsPerDegree;
  char text[32];
  std::snprintf(text,
                sizeof(text),
                "%0*ld%02ld.%03ld%c",
                num_degree_digits,
                thousandths / kThousandthsPerDegree,
                rest / 1000,
                rest % 1000,
                degrees < 0.0 ? signs[1] : signs[0]);
  return text;
}

// 001 to 360, because readers treat 000 without a runway length as unknown.
std::string Direction(double heading_deg) {
  const long rounded = (std::lround(heading_deg) + 359) % 360 + 1;
  char text[16];
  std::snprintf(text, sizeof(text), "%03ld", rounded);
  return text;
}

std::string Quoted(const std::string& text) {
  std::string quoted = CellText(OneLine(text));
  std::replace(quoted.begin(), quoted.end(), '"', '\'');
  return "\"" + quoted + "\"";
}

// Whole metres, rounded down: a pilot must not count on more than is free.
std::string Length(const StoredSite& site) {
  if (!site.final_places || !site.free_length_m) return "";
  return FixedText(std::floor(*site.free_length_m), 0) + "m";
}

std::string Description(const StoredSite& site) {
  std::string text = site.verdict == "unverified" ? "UNVERIFIED. " : "";
  text += site.summary.value_or("") + " At " + FixedText(site.touchdown.latitude_deg, 8) + " " +
          FixedText(site.touchdown.longitude_deg, 8);
  if (site.final_places) {
    text += ", heading " + FixedText(site.final_places->heading_deg, 1) + " deg";
  }
  text += ". Site " + site.id;
  if (site.altitude_datum != "amsl") text += ". Elevation left out: datum " + site.altitude_datum;
  return text + ". " + PhotographedSentence(site);
}

// Short and unique within a flight: R7, or R7F2 for a further field of that region.
std::string Code(const std::string& site_id) {
  const size_t start = site_id.rfind("-r");
  std::string code;
  for (size_t i = start == std::string::npos ? 0 : start + 1; i < site_id.size(); ++i) {
    if (site_id[i] != '-')
      code += static_cast<char>(std::toupper(static_cast<unsigned char>(site_id[i])));
  }
  return code;
}

// The format's elevation is above mean sea level. If it is empty, readers use their own terrain.
std::string Row(const StoredSite& site) {
  const std::string elevation =
      site.altitude_datum == "amsl" ? FixedText(site.touchdown.altitude_m, 1) + "m" : "";
  const std::string direction = site.final_places ? Direction(site.final_places->heading_deg) : "";
  return Quoted(site.Name()) + "," + Code(site.id) + ",," +
         Angle(site.touchdown.latitude_deg, 2, "NS") + "," +
         Angle(site.touchdown.longitude_deg, 3, "EW") + "," + elevation + "," +
         std::to_string(kOutlanding) + "," + direction + "," + Length(site) + ",," +
         Quoted(Description(site)) + "\r\n";
}

}  // namespace

std::string CupFile(const std::vector<StoredSite>& sites, const ExportOptions&) {
  std::string text = "name,code,country,lat,lon,elev,style,rwdir,rwlen,freq,desc\r\n";
  for (const StoredSite& site : SafeSites(sites, false)) text += Row(site);
  return text;
}

}  // namespace freelsd
