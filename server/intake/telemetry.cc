#include "server/intake/telemetry.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <nlohmann/json.hpp>

#include "server/intake/arrival_clock.h"

namespace freelsd {
namespace {

constexpr double kMicrosecond = 1e-6;

// Names by the number in a row of kind kPosition. 0 means that no datum was given.
constexpr std::array<const char*, 3> kDatums{"", "amsl", "ellipsoid"};

// Likewise for a row of kind kWind.
constexpr std::array<const char*, 3> kWindSources{"", "autopilot", "drift"};
constexpr double kMaxWindSdMps = 100.0;

double NumberOfDatum(const std::optional<std::string>& datum) {
  const auto found = std::find(kDatums.begin(), kDatums.end(), datum.value_or(""));
  return static_cast<double>(found - kDatums.begin());
}

std::optional<std::string> DatumOf(const std::array<double, 4>& position) {
  const auto number = static_cast<size_t>(position[3]);
  if (number == 0 || number >= kDatums.size()) return std::nullopt;
  return kDatums.at(number);
}

std::array<double, 4> Interpolated(const TelemetryRow& a, const TelemetryRow& b, double share) {
  std::array<double, 4> values{};
  if (a.kind == TelemetryKind::kAttitude) {
    const Eigen::Quaterniond qa(a.values[0], a.values[1], a.values[2], a.values[3]);
    const Eigen::Quaterniond qb(b.values[0], b.values[1], b.values[2], b.values[3]);
    const Eigen::Quaterniond between = qa.slerp(share, qb);
    return {between.w(), between.x(), between.y(), between.z()};
  }
  for (size_t i = 0; i < values.size(); ++i) {
    double step = b.values[i] - a.values[i];
    // A longitude may cross the antimeridian.
    if (a.kind == TelemetryKind::kPosition && i == 1) step = std::remainder(step, 360.0);
    values[i] = a.values[i] + share * step;
  }
  if (a.kind == TelemetryKind::kPosition) {
    values[1] = std::remainder(values[1], 360.0);
    // No altitude lies between two datums.
    values[3] = a.values[3] == b.values[3] ? a.values[3] : 0.0;
  }
  return values;
}

double SecondsBetween(int64_t from_us, int64_t to_us) {
  return static_cast<double>(to_us - from_us) * kMicrosecond;
}

// The values of a sample if it is near enough in time.
std::optional<std::array<double, 4>> Held(const std::optional<TelemetryRow>& row,
                                          int64_t timestamp_us,
                                          double max_s) {
  if (!row || std::abs(SecondsBetween(row->timestamp_us, timestamp_us)) > max_s) {
    return std::nullopt;
  }
  return row->values;
}

std::optional<std::array<double, 4>> ValuesAt(const TelemetryPair& pair,
                                              int64_t timestamp_us,
                                              const Config& config) {
  const double max_held_s = config.max_telemetry_extrapolation_s;
  if (pair.before && pair.after) {
    const double gap_s = SecondsBetween(pair.before->timestamp_us, pair.after->timestamp_us);
    if (gap_s <= 0.0) return pair.before->values;
    if (gap_s <= config.max_telemetry_gap_s) {
      const double share = SecondsBetween(pair.before->timestamp_us, timestamp_us) / gap_s;
      return Interpolated(*pair.before, *pair.after, share);
    }
  }
  if (const auto values = Held(pair.before, timestamp_us, max_held_s)) return values;
  return Held(pair.after, timestamp_us, max_held_s);
}

void SetField(TelemetryKind kind, const std::array<double, 4>& values, FrameMeta& meta) {
  if (kind == TelemetryKind::kPosition) {
    meta.position = GeoPoint{values[0], values[1], values[2]};
    meta.altitude_datum = DatumOf(values);
  } else if (kind == TelemetryKind::kAttitude) {
    meta.ned_from_body = Eigen::Quaterniond(values[0], values[1], values[2], values[3]);
  } else {
    meta.wind_in_world = Eigen::Vector2d(values[0], values[1]);
  }
}

[[noreturn]] void RefuseWind(const std::string& key, const std::string& rule) {
  const std::string detail = key + ": " + rule;
  throw ApiError("InvalidValue", detail, {{"/wind/" + key, detail}});
}

// As in a row of kind kWind.
struct WindQuality {
  double sd_mps = 0.0;
  double source = 0.0;
};

double NumberOfSource(const nlohmann::json& value) {
  const std::string name = value.is_string() ? value.get<std::string>() : "";
  const auto* const found = std::find(kWindSources.begin() + 1, kWindSources.end(), name);
  if (found == kWindSources.end()) RefuseWind("source", "must be autopilot or drift");
  return static_cast<double>(found - kWindSources.begin());
}

// Takes out of a line what the wind of a frame does not have. Null counts as absent.
WindQuality TakeWindQuality(nlohmann::json& line) {
  WindQuality quality;
  const auto wind = line.find("wind");
  if (wind == line.end() || !wind->is_object()) return quality;
  if (const auto sd = wind->find("sd_mps"); sd != wind->end()) {
    const bool is_number = sd->is_number() && std::isfinite(sd->get<double>());
    const double sd_mps = is_number ? sd->get<double>() : 0.0;
    const bool is_valid = sd->is_null() || (sd_mps > 0.0 && sd_mps <= kMaxWindSdMps);
    if (!is_valid) RefuseWind("sd_mps", "must be in (0, 100]");
    quality.sd_mps = sd_mps;
    wind->erase(sd);
  }
  if (const auto source = wind->find("source"); source != wind->end()) {
    if (!source->is_null()) quality.source = NumberOfSource(*source);
    wind->erase(source);
  }
  return quality;
}

constexpr TelemetryKind kKinds[] = {
    TelemetryKind::kPosition, TelemetryKind::kAttitude, TelemetryKind::kWind};

}  // namespace

void RefuseFutureTime(int64_t timestamp_us, int64_t now_us) {
  constexpr int64_t kDayUs = int64_t{86400} * 1000000;
  if (now_us < kFirstPlausibleUs || timestamp_us <= now_us + kDayUs) return;
  const std::string detail = "is more than a day ahead of the server's clock";
  throw ApiError("InvalidValue", "timestamp_us: " + detail, {{"/timestamp_us", detail}});
}

std::vector<TelemetryRow> ParseTelemetryLine(const std::string& line) {
  nlohmann::json object = ParseJson(line);
  for (const auto& [key, value] : object.items()) {
    const bool is_known = key == "timestamp_us" || key == "position" || key == "attitude" ||
                          key == "wind" || key == "altitude_datum";
    if (is_known) continue;
    throw ApiError("UnknownKey", key + ": is unknown", {{"/" + key, "is unknown"}});
  }
  const WindQuality quality = TakeWindQuality(object);
  const FrameMeta meta = ParseFrameMeta(object.dump());
  if (!meta.timestamp_us) {
    throw ApiError("InvalidValue", "timestamp_us: is missing", {{"/timestamp_us", "is missing"}});
  }
  std::vector<TelemetryRow> rows;
  const auto add = [&](TelemetryKind kind, const std::array<double, 4>& values) {
    rows.push_back({kind, *meta.timestamp_us, values});
  };
  if (const auto& place = meta.position) {
    add(TelemetryKind::kPosition,
        {place->latitude_deg,
         place->longitude_deg,
         place->altitude_m,
         NumberOfDatum(meta.altitude_datum)});
  }
  if (const auto& turn = meta.ned_from_body) {
    add(TelemetryKind::kAttitude, {turn->w(), turn->x(), turn->y(), turn->z()});
  }
  if (const auto& wind = meta.wind_in_world) {
    add(TelemetryKind::kWind, {wind->x(), wind->y(), quality.sd_mps, quality.source});
  }
  return rows;
}

FrameMeta TelemetryAt(const Storage& storage,
                      const Config& config,
                      const std::string& flight_id,
                      int64_t timestamp_us) {
  FrameMeta meta;
  for (const TelemetryKind kind : kKinds) {
    const auto pair = storage.telemetry.Around(flight_id, kind, timestamp_us);
    if (const auto values = ValuesAt(pair, timestamp_us, config)) SetField(kind, *values, meta);
  }
  return meta;
}

std::vector<MeasuredWind> WindsBetween(const Storage& storage,
                                       const Config& config,
                                       const std::string& flight_id,
                                       int64_t after_us,
                                       int64_t before_us) {
  // A minute and a half at 20 Hz. Older winds have no influence on the moving average. Without a
  // limit, the frontend would read for seconds after a long pause of the camera.
  constexpr size_t kMaxNumWinds = 2000;
  std::vector<MeasuredWind> winds;
  while (winds.size() < kMaxNumWinds && before_us > after_us + 1) {
    const auto row =
        storage.telemetry.Around(flight_id, TelemetryKind::kWind, before_us - 1).before;
    if (!row || row->timestamp_us <= after_us) break;
    before_us = row->timestamp_us;
    const auto places = storage.telemetry.Around(flight_id, TelemetryKind::kPosition, before_us);
    if (const auto place = ValuesAt(places, before_us, config)) {
      winds.push_back(
          {before_us, {(*place)[0], (*place)[1], (*place)[2]}, {row->values[0], row->values[1]}});
    }
  }
  std::reverse(winds.begin(), winds.end());
  return winds;
}

std::optional<std::string> WindSourceOf(const TelemetryRow& wind) {
  const auto number = static_cast<size_t>(wind.values[3]);
  if (number == 0 || number >= kWindSources.size()) return std::nullopt;
  return kWindSources.at(number);
}

std::optional<double> WindSdMps(const TelemetryRow& wind) {
  return wind.values[2] > 0.0 ? std::optional(wind.values[2]) : std::nullopt;
}

std::optional<std::string> AltitudeDatumOf(const TelemetryRow& position) {
  return DatumOf(position.values);
}

}  // namespace freelsd
