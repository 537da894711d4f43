#include "tests/evaluation/stages/stage_run.h"

#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string_view>

#include "api/api.h"
#include "api/import/images/images.h"
#include "api/import/import.h"
#include "api/import/poses/poses.h"
#include "engine/ground_map.h"
#include "tests/evaluation/stages/block_record.h"

namespace freelsd {
namespace {

constexpr const char* kModelFile = FREELSD_SOURCE_DIR "/engine/ground_kind/ground_kind.onnx";
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

std::string ReadFile(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("cannot read " + path.string());
  std::ostringstream bytes;
  bytes << file.rdbuf();
  return bytes.str();
}

// The first 32 bits of the digest: too many pixels to keep.
double DigestOf(const cv::Mat& raster) {
  const cv::Mat whole = raster.clone();
  const std::string_view bytes(reinterpret_cast<const char*>(whole.data),
                               whole.total() * whole.elemSize());
  return static_cast<double>(std::stoul(Sha256Hex(bytes).substr(0, 8), nullptr, 16));
}

void Append(std::vector<double>& values, const Eigen::Vector3d& vector) {
  values.insert(values.end(), vector.data(), vector.data() + 3);
}

void Append(std::vector<double>& values, const Rigid3d& pose) {
  const auto& quaternion = pose.rotation.coeffs();
  values.insert(values.end(), quaternion.data(), quaternion.data() + 4);
  Append(values, pose.translation);
}

StageRecords RecordsOf(const std::vector<Frame>& frames) {
  StageRecord pixels{"decoding", "digest of the pixels", {}};
  StageRecord priors{"decoding", "position told, m", {}};
  for (const Frame& frame : frames) {
    pixels.values.push_back(DigestOf(frame.image));
    Append(priors.values, frame.prior.position_in_world);
  }
  return {pixels, priors};
}

StageRecords RecordsOf(const Snapshot& snapshot) {
  StageRecord ids{"tracks", "sightings, track", {}};
  StageRecord points{"tracks", "sightings, px", {}};
  StageRecord poses{"tracks", "pose, quaternion and m", {}};
  StageRecord masks{"frontend", "digest of the grass masks", {}};
  StageRecord regions{"frontend", "regions, m, m2 and grade", {}};
  for (size_t i = 0; i < snapshot.views.size(); ++i) {
    for (const Observation& observation : snapshot.views[i].observations) {
      ids.values.push_back(static_cast<double>(observation.track_id));
      points.values.push_back(observation.point_in_image.x());
      points.values.push_back(observation.point_in_image.y());
    }
    Append(poses.values, snapshot.views[i].world_from_camera);
    masks.values.push_back(DigestOf(snapshot.kinds[i].grass));
  }
  for (const Candidate& candidate : snapshot.regions) {
    Append(regions.values, candidate.region.Center());
    regions.values.push_back(candidate.region.area_m2);
    regions.values.push_back(candidate.region.grade);
  }
  return {ids, points, poses, masks, regions};
}

StageRecords RecordsOf(const GroundSurface& surface) {
  return {RecordOf("surface", "elevation, m", surface.elevation),
          RecordOf("surface", "slope, rad", surface.slope),
          RecordOf("surface", "roughness, m", surface.roughness)};
}

StageRecords RecordsOf(const HazardLayers& layers) {
  return {RecordOf("hazard", "slope, rad", layers.slope),
          RecordOf("hazard", "roughness, m", layers.roughness),
          RecordOf("hazard", "grass, probability", layers.grass),
          RecordOf("hazard", "hazard, kind", layers.hazard),
          RecordOf("hazard", "distance, m", layers.distance)};
}

StageRecords RecordsOf(const std::vector<Plan>& plans) {
  StageRecord verdicts{"approach", "verdict", {}};
  StageRecord touchdowns{"approach", "touchdown, m", {}};
  StageRecord headings{"approach", "heading, rad", {}};
  StageRecord risks{"approach", "failure, probability", {}};
  for (const Plan& plan : plans) {
    verdicts.values.push_back(static_cast<double>(plan.verdict));
    Append(touchdowns.values, plan.touchdown_in_world);
    headings.values.push_back(plan.approach ? plan.approach->heading : kUnknown);
    risks.values.push_back(plan.score);
  }
  return {verdicts, touchdowns, headings, risks};
}

void Append(StageRecords& records, const StageRecords& more) {
  records.insert(records.end(), more.begin(), more.end());
}

std::vector<std::string> FrameIds(const FlightFolder& flight) {
  std::vector<std::string> ids;
  for (const Frame& frame : flight.frames) ids.push_back(frame.id);
  return ids;
}

Snapshot RunFrontend(const FlightFolder& flight) {
  Frontend frontend(flight.rig, flight.options, ReadGroundModel(kModelFile).model);
  for (const Frame& frame : flight.frames) frontend.Process(frame);
  frontend.Flush();
  return frontend.TakeSnapshot();
}

ImageSource ImagesOf(const FlightFolder& flight) {
  std::map<std::string, cv::Mat> images;
  for (const Frame& frame : flight.frames) images[frame.id] = frame.image;
  return [images](const std::string& id) { return images.at(id); };
}

std::vector<Plan> PlansOf(const Snapshot& snapshot,
                          const GroundLayers& ground,
                          const FlightFolder& flight) {
  const PlannableGround plannable(
      ground.map, ground.hazards, snapshot.obstacles, flight.aircraft, flight.options.hazard);
  const PlanOptions options{flight.options.approach, flight.options.backend.max_surroundings_m};
  std::vector<Plan> plans;
  for (const Candidate& candidate : snapshot.regions) {
    if (candidate.region.grade <= 0.0) continue;
    const PlanRequest request = RequestOf(candidate, snapshot.min_num_observations);
    plans.push_back(plannable.PlanFor(request, flight.aircraft, options));
  }
  return plans;
}

// Of the key-frames, at the heights of the block.
StageRecords SegmentsAlone(const FlightFolder& flight, const AdjustedBlock& block) {
  KindNetwork network(std::get<KindModel>(ReadGroundModel(kModelFile).model));
  const PipelineOptions& options = flight.options;
  const ImageSource images = ImagesOf(flight);
  StageRecord labels{"segmentation alone", "digest of the labels", {}};
  StageRecord areas{"segmentation alone", "segments, m2", {}};
  StageRecord grass{"classification alone", "grass, probability", {}};
  for (const AdjustedView& view : block.views) {
    const cv::Mat image = images(view.frame_id);
    const double height = view.height_above_ground;
    const Segments segments = SegmentFrame(image, flight.rig.camera, height, options.segmentation);
    const KindPicture kinds = network.Tell(image, height / flight.rig.camera.MeanFocalPx());
    labels.values.push_back(DigestOf(segments.labels));
    for (const Segment& segment : segments.segments) areas.values.push_back(segment.area_m2);
    for (const Label& label : LabelsOf(segments, kinds, options.classification)) {
      grass.values.push_back(label.probability);
    }
  }
  return {labels, areas, grass};
}

}  // namespace

FlightFolder ReadFlightFolder(const std::string& folder, size_t max_num_frames) {
  const std::filesystem::path path = folder;
  const FlightRequest request = ParseFlightRequest(ReadFile(path / "flight.json"));
  if (!request.camera) throw std::runtime_error(folder + "/flight.json names no camera");
  FlightFolder flight;
  flight.rig.camera = *request.camera;
  if (request.body_from_camera) flight.rig.body_from_camera = *request.body_from_camera;
  flight.aircraft = request.aircraft;
  flight.options = request.options;
  std::optional<LocalFrame> local_frame;
  for (const auto& [id, meta] : ParsePoses(ReadFile(path / "poses.csv")).poses) {
    if (flight.frames.size() == max_num_frames) break;
    if (!local_frame) local_frame.emplace(request.origin.value_or(meta.position.value()));
    const cv::Mat image = DecodeImage(ReadFile(path / id), ImageLimits{});
    const auto index = static_cast<int64_t>(flight.frames.size());
    flight.frames.push_back(MakeFrame(id, image, meta, flight.rig, *local_frame, index));
  }
  return flight;
}

StageRecords RunStages(const FlightFolder& flight) {
  StageRecords records = RecordsOf(flight.frames);
  const Snapshot snapshot = RunFrontend(flight);
  Append(records, RecordsOf(snapshot));
  const ImageSource images = ImagesOf(flight);
  const PipelineOptions& options = flight.options;
  const Box area = PhotographedArea(snapshot);
  const Selection selection = SelectViews(snapshot, area, options.adjustment, options.backend);
  const AdjustedBlock block =
      AdjustAndTie(selection.views, flight.rig.camera, images, options.tracks, options.adjustment);
  Append(records, RecordsOf(block, FrameIds(flight)));
  std::vector<StageReport> reports;
  const ElevationMap map = ReconstructMap(
      block, area, images, options, [](double) {}, reports);
  Append(records, RecordsOf(map));
  const std::vector<KindView> kind_views = AdjustedKindViews(snapshot, selection.indices, block);
  const GroundLayers ground =
      AssessGround(map, {block, kind_views, images}, flight.aircraft, options.hazard, reports);
  Append(records, RecordsOf(ground.hazards));
  Append(records, RecordsOf(PlansOf(snapshot, ground, flight)));
  return records;
}

StageRecords RunStagesAlone(const FlightFolder& flight, const StageRecords& adjusted) {
  StageRecords records = RecordsOf(flight.frames);
  const AdjustedBlock block = BlockFrom(adjusted, flight.rig.camera, FrameIds(flight));
  Append(records, SegmentsAlone(flight, block));
  std::vector<StageReport> reports;
  const ElevationMap map = ReconstructMap(
      block, SeenArea(block), ImagesOf(flight), flight.options, [](double) {}, reports);
  Append(records, RecordsOf(map));
  Append(records, RecordsOf(MeasureSurface(MapFrom(adjusted), flight.options.hazard.surface)));
  return records;
}

}  // namespace freelsd
