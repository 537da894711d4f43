// Requests to emergency recall over the meadow.
#pragma once

#include <chrono>
#include <string>

#include "tests/server/meadow.h"
#include "tests/server/site_on_map.h"

namespace freelsd {

// 500 m south of the meadow's touchdown, flying north; the meadow lies at 400 m.
inline std::string Query(double altitude_m, const std::string& more = "") {
  return "/v1/emergency?latitude_deg=46.9955&longitude_deg=8.0&altitude_m=" +
         std::to_string(altitude_m) + more;
}

inline constexpr char kCalmNorth[] =
    "&wind_east_mps=0&wind_north_mps=0&heading_deg=0&altitude_datum=amsl";

inline void StoreAmslMeadow(Storage& storage) { PutOnMap(storage, MeadowSite("amsl"), Meadow()); }

// An answer is cut short when planning takes too long; what was planned is kept, so that a busy
// machine gets there in a few requests.
inline nlohmann::json WholeAnswer(httplib::Client& client, const std::string& path) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::minutes(3);
  nlohmann::json answer;
  do {
    answer = GetJson(client, path);
  } while (answer["warnings"].dump().find("not every stored site") != std::string::npos &&
           std::chrono::steady_clock::now() < deadline);
  return answer;
}

}  // namespace freelsd
