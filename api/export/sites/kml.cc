// KML 2.2. Its heights are above mean sea level. Sites of another datum are drawn on the ground,
// and the description names the datum.
#include "api/export/sites/site_export.h"

namespace freelsd {
namespace {

// aabbggrr; colour-blind people can distinguish the colours.
constexpr char kStyles[] =
    "<Style "
    "id=\"landable\"><LineStyle><color>ffb27200</color><width>3</width></LineStyle></Style>\n"
    "<Style id=\"unverified\"><LineStyle><color>ff00c8ff</color><width>3</width></LineStyle>"
    "</Style>\n"
    "<Style "
    "id=\"rejected\"><LineStyle><color>ff005ed5</color><width>3</width></LineStyle></Style>\n";

std::string Coordinates(const GeoPoint& place) {
  return FixedText(place.longitude_deg, 9) + "," + FixedText(place.latitude_deg, 9) + "," +
         FixedText(place.altitude_m, 3);
}

std::string Element(const std::string& name, const std::string& content) {
  return "<" + name + ">" + content + "</" + name + ">";
}

std::string AltitudeMode(const StoredSite& site) {
  return Element("altitudeMode", site.altitude_datum == "amsl" ? "absolute" : "clampToGround");
}

std::string Placemark(const StoredSite& site,
                      const std::string& kind,
                      const std::string& more,
                      const std::string& geometry) {
  return "<Placemark>" + Element("name", EscapeXml(site.Name() + kind)) + more +
         Element("styleUrl", "#" + (site.IsRejected() ? "rejected" : site.verdict)) + geometry +
         "</Placemark>\n";
}

std::string Line(const StoredSite& site, const std::string& coordinates) {
  return Element("LineString", AltitudeMode(site) + Element("coordinates", coordinates));
}

std::string Data(const std::string& name, const std::string& value) {
  return "<Data name=\"" + name + "\">" + Element("value", EscapeXml(value)) + "</Data>";
}

std::string ExtendedData(const StoredSite& site) {
  std::string data = Data("site_id", site.id) + Data("verdict", site.verdict) +
                     Data("altitude_datum", site.altitude_datum) +
                     Data("altitude_m", FixedText(site.touchdown.altitude_m, 3));
  if (site.last_seen_at && site.age_s) {
    data += Data("last_seen_at", *site.last_seen_at) + Data("age_s", FixedText(*site.age_s, 0));
  }
  if (site.final_places) {
    data += Data("heading_deg", FixedText(site.final_places->heading_deg, 3)) +
            Data("approach_distance_m", FixedText(site.final_places->distance_m, 3)) +
            Data("approach_height_m", FixedText(site.final_places->height_m, 3)) +
            Data("loiter_radius_m", FixedText(site.final_places->loiter_radius_m, 3)) +
            Data("loiter_direction", site.final_places->is_right_turn ? "right" : "left");
  }
  if (site.go_around) {
    data += Data("no_return_distance_m", FixedText(site.go_around->no_return_distance_m, 3)) +
            Data("go_around_unseen_ratio", FixedText(site.go_around->unseen_ratio, 3));
  }
  return Element("ExtendedData", data);
}

std::string LoiterCoordinates(const StoredSite& site) {
  std::string text;
  for (const GeoPoint& place : site.final_places->circle) {
    text += (text.empty() ? "" : " ") + Coordinates(place);
  }
  return text;
}

std::string SiteFolder(const StoredSite& site) {
  std::string description = site.summary.value_or("") + " Site " + site.id + ", touchdown at " +
                            FixedText(site.touchdown.latitude_deg, 6) + " " +
                            FixedText(site.touchdown.longitude_deg, 6) + ". " +
                            PhotographedSentence(site);
  if (site.altitude_datum != "amsl") {
    description += " Altitudes are in the datum \"" + site.altitude_datum +
                   "\", so places are drawn on the ground.";
  }
  std::string text =
      "<Folder>" + Element("name", EscapeXml(site.Name())) + "\n" +
      Placemark(
          site,
          "",
          Element("description", EscapeXml(description)),
          ExtendedData(site) +
              Element("Point",
                      AltitudeMode(site) + Element("coordinates", Coordinates(site.touchdown))));
  if (site.final_places) {
    text += Placemark(
        site,
        " approach",
        "",
        Line(site, Coordinates(site.final_places->start) + " " + Coordinates(site.touchdown)));
    text += Placemark(site, " loiter", "", Line(site, LoiterCoordinates(site)));
  }
  if (site.go_around) {
    text += Placemark(
        site,
        " go-around",
        "",
        Line(site, Coordinates(site.go_around->start) + " " + Coordinates(site.go_around->end)));
  }
  return text + "</Folder>\n";
}

}  // namespace

std::string KmlFile(const std::vector<StoredSite>& sites, const ExportOptions&) {
  std::string text =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<kml xmlns=\"http://www.opengis.net/kml/2.2\"><Document><name>Landing sites</name>\n" +
      std::string(kStyles);
  for (const StoredSite& site : sites) text += SiteFolder(site);
  return text + "</Document></kml>\n";
}

}  // namespace freelsd
