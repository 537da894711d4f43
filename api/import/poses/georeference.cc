// Transforms poses from the local frame of a reconstruction to the earth.
#include <cmath>
#include <map>
#include <set>

#include <Eigen/Geometry>
#include <Eigen/SVD>

#include "api/import/poses/side_files.h"

namespace freelsd {
namespace {

constexpr size_t kMinNumGeotags = 3;
// Least width over length of the geotags. On a line, the rotation about that line is unknown.
constexpr double kMinBreadthRatio = 0.02;
// A larger residual causes the warning PoorFit: consumer receivers are better.
constexpr double kMaxResidualM = 10.0;

// world (east, north, up about the origin) = scale * rotation * local + translation.
struct Georeferencing {
  GeoPoint origin;
  double scale = 1.0;
  Rigid3d world_from_local;
  double residual_m = 0.0;
  // Datum of the altitudes; empty if unknown.
  std::optional<std::string> altitude_datum;
};

Georeferencing AboutOrigin(const GeoPoint& origin) {
  Georeferencing reference;
  reference.origin = origin;
  return reference;
}

ApiError UnusablePoses(const std::string& detail) {
  return ApiError("InvalidPoses", detail, {{"/poses", detail}});
}

bool LieOnLine(const Eigen::Matrix3Xd& points) {
  const Eigen::Matrix3Xd centered = points.colwise() - points.rowwise().mean();
  const Eigen::Vector3d sizes = Eigen::JacobiSVD<Eigen::Matrix3Xd>(centered).singularValues();
  return sizes[1] <= kMinBreadthRatio * sizes[0];
}

// The common datum of all positions in files and tags. Nothing if a position has no datum, or if
// two datums differ.
std::optional<std::string> CommonDatum(const SideContext& context, const PoseFile& file) {
  std::set<std::optional<std::string>> datums;
  for (const auto* metas : {&context.image_tags, &file.poses}) {
    for (const auto& [image_id, meta] : *metas) {
      if (meta.position) datums.insert(meta.altitude_datum);
    }
  }
  return datums.size() == 1 ? *datums.begin() : std::nullopt;
}

std::map<std::string, GeoPoint> GeotagsOf(const SideContext& context, const PoseFile& file) {
  std::map<std::string, GeoPoint> geotags;
  for (const auto& [image_id, tags] : context.image_tags) {
    if (tags.position) geotags[image_id] = *tags.position;
  }
  // Positions in a file are preferred to tags.
  for (const auto& [image_id, meta] : file.poses) {
    if (meta.position) geotags[image_id] = *meta.position;
  }
  return geotags;
}

// Umeyama 1991, on the places of cameras with a geotag.
std::optional<Georeferencing> FitToGeotags(const std::vector<LocalPose>& poses,
                                           const std::map<std::string, GeoPoint>& geotags) {
  std::vector<std::pair<Eigen::Vector3d, GeoPoint>> pairs;
  for (const LocalPose& pose : poses) {
    const auto geotag = geotags.find(pose.image_id);
    if (geotag == geotags.end()) continue;
    pairs.emplace_back(pose.local_from_camera.translation, geotag->second);
  }
  if (pairs.size() < kMinNumGeotags) return std::nullopt;
  Georeferencing fit;
  fit.origin = pairs[0].second;
  const LocalFrame frame(fit.origin);
  Eigen::Matrix3Xd local(3, pairs.size()), world(3, pairs.size());
  for (size_t i = 0; i < pairs.size(); ++i) {
    local.col(static_cast<long>(i)) = pairs[i].first;
    world.col(static_cast<long>(i)) = frame.WorldFromGeo(pairs[i].second);
  }
  if (LieOnLine(local) || LieOnLine(world)) {
    throw UnusablePoses("the geotags lie on a line: the rotation of the poses is unknown");
  }
  const Eigen::Matrix4d world_from_local = Eigen::umeyama(local, world, true);
  const Eigen::Matrix3d scaled = world_from_local.topLeftCorner<3, 3>();
  fit.scale = std::cbrt(scaled.determinant());
  fit.world_from_local = {Eigen::Quaterniond(Eigen::Matrix3d(scaled / fit.scale)).normalized(),
                          world_from_local.topRightCorner<3, 1>()};
  const Eigen::Matrix3Xd errors =
      (scaled * local).colwise() + fit.world_from_local.translation - world;
  fit.residual_m = std::sqrt(errors.colwise().squaredNorm().mean());
  return fit;
}

Georeferencing ReferenceOf(const std::vector<LocalPose>& poses,
                           const std::map<std::string, GeoPoint>& geotags,
                           const SideContext& context,
                           const SideData& data) {
  if (data.local_origin) return AboutOrigin(*data.local_origin);
  if (auto fit = FitToGeotags(poses, geotags)) {
    fit->altitude_datum = CommonDatum(context, data.file);
    return *fit;
  }
  throw UnusablePoses("local poses need positions of at least 3 images (geotags, geo.txt or CSV)");
}

FrameMeta MetaOf(const LocalPose& pose, const Georeferencing& reference, const LocalFrame& frame) {
  const Rigid3d& world_from_local = reference.world_from_local;
  const Eigen::Vector3d position_in_world =
      reference.scale * (world_from_local.rotation * pose.local_from_camera.translation) +
      world_from_local.translation;
  FrameMeta meta;
  meta.position = frame.GeoFromWorld(position_in_world);
  meta.altitude_datum = reference.altitude_datum;
  meta.ned_from_camera =
      (WorldFromNed().conjugate() * world_from_local.rotation * pose.local_from_camera.rotation)
          .normalized();
  return meta;
}

// Products of finite numbers from a file may be infinite.
bool IsFinite(const FrameMeta& meta) {
  return std::isfinite(meta.position->latitude_deg) &&
         std::isfinite(meta.position->longitude_deg) && std::isfinite(meta.position->altitude_m) &&
         meta.ned_from_camera->coeffs().allFinite();
}

std::vector<Eigen::Quaterniond> AttitudesOf(const std::vector<LocalPose>& poses,
                                            const Georeferencing& reference) {
  const LocalFrame frame(reference.origin);
  std::vector<Eigen::Quaterniond> attitudes;
  attitudes.reserve(poses.size());
  for (const LocalPose& pose : poses) {
    attitudes.push_back(*MetaOf(pose, reference, frame).ned_from_camera);
  }
  return attitudes;
}

// Without its own reference the second reading is not compared.
bool IsWLastLikelyOf(const std::map<std::string, GeoPoint>& geotags,
                     const SideContext& context,
                     const SideData& data,
                     const Georeferencing& reference) {
  if (data.local_poses_w_last.empty()) return false;
  try {
    const Georeferencing other = ReferenceOf(data.local_poses_w_last, geotags, context, data);
    return IsWLastLikely(AttitudesOf(data.local_poses, reference),
                         AttitudesOf(data.local_poses_w_last, other));
  } catch (const ApiError&) {
    return false;
  }
}

std::string MetresText(double metres) {
  return std::to_string(static_cast<long>(std::lround(metres))) + " m";
}

void WarnOf(const Georeferencing& reference, SideData& data) {
  std::vector<std::string>& warnings = data.file.warnings;
  if (data.local_origin) return;
  if (reference.residual_m > kMaxResidualM) {
    warnings.push_back("PoorFit: poses and geotags differ by " + MetresText(reference.residual_m) +
                       " after the best fit");
  } else {
    warnings.push_back("local poses were fitted to geotags, to " +
                       MetresText(reference.residual_m) + " on average");
  }
}

}  // namespace

void Georeference(SideData& data) {
  const SideContext& context = data.context;
  if (data.local_poses.empty()) return;
  const std::map<std::string, GeoPoint> geotags = GeotagsOf(context, data.file);
  const Georeferencing reference = ReferenceOf(data.local_poses, geotags, context, data);
  WarnOf(reference, data);
  if (IsWLastLikelyOf(geotags, context, data, reference)) {
    data.file.warnings.emplace_back(
        "QuaternionOrder: the cameras look down only if the quaternions are read w last; they are "
        "read w first");
  }
  std::map<std::string, FrameMeta> known;
  for (auto& [image_id, meta] : data.file.poses) known[image_id] = std::move(meta);
  data.file.poses.clear();
  const LocalFrame frame(reference.origin);
  for (const LocalPose& pose : data.local_poses) {
    FrameMeta meta = MetaOf(pose, reference, frame);
    if (!IsFinite(meta)) {
      throw UnusablePoses("the pose of " + pose.image_id + " has numbers beyond all bounds");
    }
    // Other files of the same images supply values that a reconstruction lacks.
    if (const auto other = known.find(pose.image_id); other != known.end()) {
      meta = Merged(meta, other->second);
      known.erase(other);
    }
    data.file.poses.emplace_back(pose.image_id, std::move(meta));
  }
  for (auto& [image_id, meta] : known) data.file.poses.emplace_back(image_id, std::move(meta));
}

}  // namespace freelsd
