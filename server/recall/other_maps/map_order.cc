// Which of two flights photographed the ground later.
#include "api/stored/stored.h"
#include "server/recall/other_maps/other_maps.h"

namespace freelsd {

bool IsLater(const MapRow& map, const SiteRow& site) {
  return map.flight_id != site.flight_id && IsLater(SeenOf(map), SeenOf(site));
}

bool MayBeLater(const MapRow& map, const SiteRow& site) {
  if (map.flight_id == site.flight_id) return false;
  return IsLater(SeenOf(map), SeenOf(site)) || IsContested(SeenOf(map), SeenOf(site));
}

bool IsLaterThanMap(const StoredSites& stored, const MapRow& map, const SiteRow& site) {
  if (!IsLater(map, site)) return false;
  const auto own = stored.maps.flight_maps().Find(stored.storage, site.map_id);
  return !own || IsLater(SeenOf(map), SeenOf(own->row));
}

std::string OnOtherMap(const std::string& name, bool is_later) {
  return is_later ? "on the later map of " + name + " "
                  : "on the map of " + name + ", which may be later or earlier, ";
}

}  // namespace freelsd
