#include "api/import/poses/pose_columns.h"

#include <algorithm>
#include <cctype>
#include <set>
#include <utility>

#include "api/import/import.h"
#include "api/import/number_text.h"
#include "api/import/poses/pose_line.h"
#include "api/import/poses/poses.h"

namespace freelsd {
namespace {

constexpr size_t kMaxShownNameBytes = 60;
// Cells from which a header is recognised.
constexpr size_t kMaxNumLookedAt = 64;

// How a column's name, split into words, names a field: it is one of `whole` when joined; or one of
// its words is in `any`, one is in `with` where that is not empty, and all others are in `beside`.
struct FieldRule {
  PoseField field;
  std::string_view name;
  std::string_view meta_pointer;
  Quantity quantity;
  std::string_view any;
  std::string_view with;
  std::string_view beside;
};

constexpr std::string_view kPlaceWords =
    "gps gnss rtk ppk drone aircraft uav uas camera cam image photo wgs wgs84 84 corrected final "
    "position pos geo dd decimal x y z measured exif";
constexpr std::string_view kAltitudeWords =
    "gps gnss rtk ppk drone aircraft uav uas camera cam image photo wgs wgs84 84 corrected final "
    "position pos geo dd decimal x y z measured exif abs absolute amsl msl asl above mean sea "
    "level sealevel hae ellipsoid ellipsoidal egm96 orthometric";
constexpr std::string_view kBodyWords = "body aircraft uav uas drone flight vehicle imu ins angle";
constexpr std::string_view kHeightWords = "alt altitude height above home off";

using F = PoseField;
using Q = Quantity;

// Words are in order of trust.
constexpr FieldRule kRules[] = {
    {F::kImage,
     "image",
     "",
     Q::kNone,
     "image imagename imageid file filename img photo photoid picture label sourcefile name",
     "",
     "name source file"},
    {F::kLatitude,
     "latitude_deg",
     "/position/latitude_deg",
     Q::kAngle,
     "latitude lat",
     "",
     kPlaceWords},
    {F::kLongitude,
     "longitude_deg",
     "/position/longitude_deg",
     Q::kAngle,
     "longitude lon lng long",
     "",
     kPlaceWords},
    {F::kAltitude,
     "altitude_m",
     "/position/altitude_m",
     Q::kLength,
     "altitude alt elevation elev ellh height z",
     "",
     kAltitudeWords},
    {F::kX, "x", "", Q::kLength, "easting east coordinate2 x", "", "x utm coordinate coord"},
    {F::kY, "y", "", Q::kLength, "northing north coordinate1 y", "", "y utm coordinate coord"},
    {F::kLatitudeLongitude, "position", "", Q::kNone, "gpsposition", "", "gps position"},
    {F::kLatitudeRef, "latitude_ref", "", Q::kNone, "ref hemisphere ns", "latitude lat ns", "gps"},
    {F::kLongitudeRef,
     "longitude_ref",
     "",
     Q::kNone,
     "ref hemisphere ew",
     "longitude lon ew",
     "gps"},
    {F::kAltitudeRef, "altitude_ref", "", Q::kNone, "ref", "altitude alt", "gps"},
    {F::kTime,
     "timestamp_us",
     "",
     Q::kTime,
     "timestamp utc datetime time",
     "",
     "date gps local original create capture gmt"},
    {F::kRoll, "roll_deg", "/attitude/roll_deg", Q::kAngle, "roll", "", kBodyWords},
    {F::kPitch, "pitch_deg", "/attitude/pitch_deg", Q::kAngle, "pitch", "", kBodyWords},
    {F::kYaw, "yaw_deg", "/attitude/yaw_deg", Q::kAngle, "yaw heading", "", kBodyWords},
    {F::kOmega, "omega_deg", "", Q::kAngle, "omega", "", ""},
    {F::kPhi, "phi_deg", "", Q::kAngle, "phi", "", ""},
    {F::kKappa, "kappa_deg", "", Q::kAngle, "kappa", "", ""},
    {F::kQuaternionW, "qw", "", Q::kNone, "qw quatw quaternionw", "", ""},
    {F::kQuaternionX, "qx", "", Q::kNone, "qx quatx quaternionx", "", ""},
    {F::kQuaternionY, "qy", "", Q::kNone, "qy quaty quaterniony", "", ""},
    {F::kQuaternionZ, "qz", "", Q::kNone, "qz quatz quaternionz", "", ""},
    {F::kGimbalRoll, "gimbal_roll_deg", "", Q::kAngle, "roll", "gimbal camera cam", "angle"},
    {F::kGimbalPitch, "gimbal_pitch_deg", "", Q::kAngle, "pitch", "gimbal camera cam", "angle"},
    {F::kGimbalYaw, "gimbal_yaw_deg", "", Q::kAngle, "yaw heading", "gimbal camera cam", "angle"},
    {F::kImageUpHeading, "image_up_heading_deg", "", Q::kAngle, "heading", "up top", "image"},
    {F::kWindEast, "wind_east_mps", "", Q::kSpeed, "windeast", "", ""},
    {F::kWindNorth, "wind_north_mps", "", Q::kSpeed, "windnorth", "", ""},
    {F::kWindFrom,
     "wind_from_deg",
     "",
     Q::kAngle,
     "windfrom winddirectionfrom winddirection winddir",
     "",
     ""},
    {F::kWindTo, "wind_to_deg", "", Q::kAngle, "windto winddirectionto windtowards", "", ""},
    {F::kWindSpeed, "wind_speed_mps", "", Q::kSpeed, "windspeed", "", ""},
    {F::kHeightAboveGround,
     "height_above_ground_m",
     "/height_above_ground_m",
     Q::kLength,
     "agl ground",
     "",
     kHeightWords},
    {F::kHeightAboveTakeOff,
     "relative_altitude_m",
     "",
     Q::kLength,
     "rel relative takeoff take",
     "alt altitude height",
     kHeightWords},
    {F::kPositionSd,
     "position_sd_m",
     "/position_sd_m",
     Q::kLength,
     "positionsd gpsxyaccuracy horizontalaccuracy accuracyhorizontal",
     "",
     ""},
    {F::kAttitudeSd, "attitude_sd_deg", "/attitude_sd_deg", Q::kAngle, "attitudesd", "", ""},
};

const FieldRule& RuleOf(PoseField field) {
  return *std::find_if(std::begin(kRules), std::end(kRules), [field](const auto& rule) {
    return rule.field == field;
  });
}

// Place of the word in the list; nothing if it is not in it.
std::optional<size_t> PlaceIn(std::string_view list, const std::string& word) {
  size_t place = 0;
  while (!list.empty()) {
    const size_t end = std::min(list.find(' '), list.size());
    if (list.substr(0, end) == word) return place;
    list.remove_prefix(std::min(end + 1, list.size()));
    ++place;
  }
  return std::nullopt;
}

struct ColumnName {
  // Lower case.
  std::vector<std::string> words;
  std::optional<Unit> unit;
  // Brackets hold what is neither a unit nor known not to be one.
  bool has_unknown_unit = false;
};

bool IsUpper(char c) { return c >= 'A' && c <= 'Z'; }
bool IsWordCharacter(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0; }

// "GPSLatitude", "GPS latitude" and "gps_latitude" are the same two words.
std::vector<std::string> SplitName(std::string_view name) {
  std::vector<std::string> words(1);
  for (size_t i = 0; i < name.size(); ++i) {
    const char before = i > 0 ? name[i - 1] : ' ', after = i + 1 < name.size() ? name[i + 1] : ' ';
    const bool is_hump =
        IsUpper(name[i]) && IsWordCharacter(before) &&
        (!IsUpper(before) || (std::islower(static_cast<unsigned char>(after)) != 0));
    if ((is_hump || !IsWordCharacter(name[i])) && !words.back().empty()) words.emplace_back();
    if (IsWordCharacter(name[i])) words.back() += name[i];
  }
  if (words.back().empty()) words.pop_back();
  for (std::string& word : words) word = InLowerCase(word);
  return words;
}

// What stands in brackets: a unit, or a remark that is none.
void ReadBracket(std::string_view text, ColumnName& name) {
  name.unit = UnitFromText(text);
  if (name.unit) return;
  for (const std::string& word : SplitName(text)) {
    const bool is_datum =
        PlaceIn(kAltitudeWords, word) || PlaceIn("utc gmt degrees epsg 4326 4979", word);
    name.has_unknown_unit = name.has_unknown_unit || !is_datum;
  }
}

ColumnName ParseName(std::string_view text) {
  ColumnName name;
  const size_t open = text.find_first_of("([");
  if (open != std::string_view::npos) {
    const size_t close = std::min(text.find_first_of(")]", open), text.size());
    ReadBracket(Trimmed(text.substr(open + 1, close - open - 1)), name);
  }
  name.words = SplitName(text.substr(0, open));
  const bool is_side = name.words == std::vector<std::string>{"n", "s"};
  if (name.unit || name.words.size() < 2 || is_side) return name;
  name.unit = UnitFromText(name.words.back());
  if (name.unit) name.words.pop_back();
  return name;
}

// Nothing if the name does not name the field; small for a name that surely does.
std::optional<size_t> RankOf(const ColumnName& name, const FieldRule& rule) {
  constexpr size_t kWordWeight = 100;
  std::string joined;
  for (const std::string& word : name.words) joined += word;
  const auto whole = PlaceIn(rule.any, joined);
  if (whole && (rule.with.empty() || PlaceIn(rule.with, joined))) return *whole;
  std::optional<size_t> any;
  bool has_with = rule.with.empty();
  size_t rank = kWordWeight * name.words.size();
  for (const std::string& word : name.words) {
    const auto place = PlaceIn(rule.any, word);
    const bool is_with = PlaceIn(rule.with, word).has_value();
    if (!place && !is_with && !PlaceIn(rule.beside, word)) return std::nullopt;
    if (place) any = std::min(any.value_or(*place), *place);
    has_with = has_with || is_with;
    // A height above sea level is preferred to one above the ellipsoid.
    if (word == "hae" || word.starts_with("ellip")) rank += kWordWeight / 2;
  }
  if (!any || !has_with) return std::nullopt;
  return rank + *any;
}

// Lower case, without a comment's #, "_" for spaces and what is not printable.
std::string Harmless(const std::string& name) {
  const size_t first = name.find_first_not_of(" \t\r#");
  if (first == std::string::npos) return "";
  std::string plain = name.substr(first, name.find_last_not_of(" \t\r") - first + 1);
  for (char& c : plain) c = c <= ' ' || c > '~' ? '_' : c;
  return InLowerCase(plain.substr(0, kMaxShownNameBytes));
}

std::optional<size_t> BestColumn(const std::vector<ColumnName>& names,
                                 const std::set<size_t>& claimed,
                                 const FieldRule& rule) {
  std::optional<size_t> best;
  size_t best_rank = 0;
  for (size_t i = 0; i < names.size(); ++i) {
    if (claimed.contains(i) || names[i].words.empty()) continue;
    const std::optional<size_t> rank = RankOf(names[i], rule);
    if (!rank || (best && best_rank <= *rank)) continue;
    best = i;
    best_rank = *rank;
  }
  return best;
}

// The first unclaimed column whose cells are all names of images, whatever its own name.
std::optional<size_t> ColumnOfImages(const Table& table, const std::set<size_t>& claimed) {
  for (size_t i = 0; i < table.header->cells.size(); ++i) {
    const bool is_named =
        std::all_of(table.lines.begin(), table.lines.end(), [i](const auto& line) {
          return i < line.cells.size() && IsImageName(line.cells[i]);
        });
    if (is_named && !table.lines.empty() && !claimed.contains(i)) return i;
  }
  return std::nullopt;
}

bool HasUsableUnit(const ColumnName& name, const FieldRule& rule) {
  if (rule.quantity == Quantity::kNone) return true;
  const bool is_either = rule.field == F::kX || rule.field == F::kY;
  return !name.has_unknown_unit &&
         (!name.unit || name.unit->quantity == rule.quantity || is_either);
}

void WarnOfUnused(const std::vector<std::string>& cells,
                  const std::set<size_t>& claimed,
                  PoseColumns& header) {
  std::string unused;
  for (size_t i = 0; i < cells.size(); ++i) {
    const std::string name = Harmless(cells[i]);
    if (name.empty()) {
      header.unnamed.push_back(i);
    } else if (name.find("track") != std::string::npos ||
               name.find("course") != std::string::npos) {
      header.warnings.push_back("column \"" + name + "\"" +
                                " is the track over ground, not the heading: ignored");
    } else if (!claimed.contains(i)) {
      unused += (unused.empty() ? "\"" : ", \"") + name + "\"";
    }
  }
  if (!unused.empty()) header.warnings.push_back("columns that are not used: " + unused);
}

// Removes the quaternion if a part is missing, or if roll, pitch and yaw are all given.
PoseColumns WithOneAttitude(PoseColumns header) {
  const auto has = [&header](PoseField field) { return header.Has(field); };
  if (std::none_of(kQuaternionFields.begin(), kQuaternionFields.end(), has)) return header;
  if (!std::all_of(kQuaternionFields.begin(), kQuaternionFields.end(), has)) {
    header.warnings.emplace_back("a quaternion needs qw, qx, qy and qz: ignored");
  } else if (has(F::kRoll) && has(F::kPitch) && has(F::kYaw)) {
    header.warnings.emplace_back("roll, pitch and yaw are used, the quaternion is ignored");
  } else {
    header.warnings.emplace_back(
        "qw, qx, qy, qz are read as the rotation from body (forward, right, down) to north, east, "
        "down");
    return header;
  }
  for (const PoseField field : kQuaternionFields) header.columns.erase(field);
  return header;
}

void RequireColumns(const PoseColumns& header, int line) {
  std::vector<PoseField> needed{F::kImage};
  if (!header.Has(F::kX) && !header.Has(F::kLatitudeLongitude)) {
    needed.insert(needed.end(), {F::kLatitude, F::kLongitude});
  }
  for (const PoseField field : needed) {
    const std::string name(NameOf(field));
    if (header.Has(field)) continue;
    throw InvalidPose(LinePointer(line) + "/" + name, "the column " + name + " is needed");
  }
}

}  // namespace

std::optional<std::string> PoseColumns::AltitudeDatum() const {
  const auto altitude = columns.find(PoseField::kAltitude);
  if (altitude == columns.end()) return std::nullopt;
  const std::string& name = altitude->second.name;
  const auto has = [&name](const char* word) { return name.find(word) != std::string::npos; };
  if (has("msl") || has("sea") || has("asl") || has("egm96") || has("orthometric")) return "amsl";
  return has("hae") || has("ellip") || has("ellh") ? std::optional<std::string>("ellipsoid")
                                                   : std::nullopt;
}

std::string_view NameOf(PoseField field) { return RuleOf(field).name; }

std::string_view MetaPointerOf(PoseField field) { return RuleOf(field).meta_pointer; }

Quantity QuantityOf(PoseField field) { return RuleOf(field).quantity; }

size_t NumKnownColumns(const std::vector<std::string>& cells) {
  std::set<size_t> fields;
  for (size_t column = 0; column < std::min(cells.size(), kMaxNumLookedAt); ++column) {
    if (cells[column].size() > kMaxShownNameBytes) continue;
    const ColumnName name = ParseName(cells[column]);
    for (size_t i = 0; !name.words.empty() && i < std::size(kRules); ++i) {
      if (RankOf(name, kRules[i])) fields.insert(i);
    }
  }
  return fields.size();
}

PoseColumns ReadHeader(const Table& table) {
  const TableLine& line = *table.header;
  const std::vector<std::string>& cells = line.cells;
  if (cells.size() > kLimits.poses.max_num_columns) {
    throw InvalidPose(LinePointer(line.number), "the pose file has too many columns");
  }
  std::vector<ColumnName> names(cells.size());
  std::transform(cells.begin(), cells.end(), names.begin(), ParseName);
  PoseColumns header;
  std::set<size_t> claimed;
  for (const FieldRule& rule : kRules) {
    const std::optional<size_t> best = BestColumn(names, claimed, rule);
    if (!best) continue;
    const std::string name = Harmless(cells[*best]);
    claimed.insert(*best);
    if (!HasUsableUnit(names[*best], rule)) {
      header.warnings.push_back("column \"" + name + "\"" + " has an unknown unit: ignored");
      continue;
    }
    for (size_t i = *best + 1; i < cells.size(); ++i) {
      if (Harmless(cells[i]) != name) continue;
      throw InvalidPose(LinePointer(line.number) + "/" + name,
                        "the column \"" + name + "\"" + " comes twice");
    }
    header.columns[rule.field] = {*best, name, names[*best].unit};
  }
  if (!header.Has(F::kX)) header.columns.erase(F::kY);
  if (!header.Has(F::kY)) header.columns.erase(F::kX);
  if (const auto images = header.Has(F::kImage) ? std::nullopt : ColumnOfImages(table, claimed)) {
    header.columns[F::kImage] = {*images, Harmless(cells[*images]), {}};
    claimed.insert(*images);
  }
  RequireColumns(header, line.number);
  WarnOfUnused(cells, claimed, header);
  return WithOneAttitude(std::move(header));
}

}  // namespace freelsd
