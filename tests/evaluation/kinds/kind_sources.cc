#include "tests/evaluation/kinds/kind_sources.h"

#include <algorithm>
#include <filesystem>
#include <limits>
#include <map>
#include <stdexcept>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "server/training/labelled_photographs.h"
#include "tests/evaluation/fields/field_survey.h"
#include "tests/evaluation/kinds/ground_run.h"
#include "tests/evaluation/recorded/recorded_flight.h"
#include "tests/evaluation/runs/runs.h"
#include "tests/evaluation/truth_map.h"

namespace freelsd {
namespace {

constexpr float kOnlyReported = std::numeric_limits<float>::quiet_NaN();
// The map may be shifted against the truth: meadow nearer than this to anything else does not
// count, nor other ground nearer than that to a meadow.
constexpr double kMeadowMarginM = 2.0;
constexpr double kOtherMarginM = 1.0;

// Kinds by name, in the order in which they appear.
class KindMap {
 public:
  explicit KindMap(const cv::Size& size) { rasters_.kind = cv::Mat1b::zeros(size); }
  void Set(int row, int col, const std::string& kind, float is_fit) {
    const auto [found, is_new] = index_.try_emplace(kind, rasters_.kinds.size());
    if (is_new) {
      rasters_.kinds.push_back(kind);
      rasters_.is_fit.push_back(is_fit);
    }
    rasters_.kind(row, col) = static_cast<uint8_t>(found->second + 1);
  }
  KindRasters Take() { return std::move(rasters_); }

 private:
  KindRasters rasters_;
  std::map<std::string, size_t> index_;
};

cv::Mat1b Eroded(const cv::Mat1b& mask, double margin_m, double cell_size_m) {
  const int half = static_cast<int>(std::lround(margin_m / cell_size_m));
  cv::Mat1b inner;
  cv::erode(
      mask, inner, cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * half + 1, 2 * half + 1}));
  return inner;
}

// Narrower than the margins.
bool IsThing(Cover cover) {
  return cover == Cover::kBoulder || cover == Cover::kDitch || cover == Cover::kFence ||
         cover == Cover::kPole || cover == Cover::kVehicle || cover == Cover::kAnimal ||
         cover == Cover::kHedge || cover == Cover::kRoad;
}

KindRasters TrueKinds(const ElevationMap& map, const TruthMap& truth) {
  const Grid& grid = map.grid;
  const cv::Mat1b meadow = (truth.cover == static_cast<uint8_t>(Cover::kMeadow)) &
                           (truth.fault != static_cast<uint8_t>(GroundFault::kCover));
  const cv::Mat1b is_inner_meadow = Eroded(meadow, kMeadowMarginM, truth.cell_size_m);
  const cv::Mat1b is_inner_other = Eroded(~meadow, kOtherMarginM, truth.cell_size_m);
  KindMap kinds({grid.num_cols, grid.num_rows});
  for (int row = 0; row < grid.num_rows; ++row) {
    for (int col = 0; col < grid.num_cols; ++col) {
      const Eigen::Vector2d place = grid.CellCenter(row, col);
      if (!map.IsSeen(row, col) || place.cwiseAbs().maxCoeff() > 0.5 * truth.size_m) continue;
      const cv::Point cell = truth.CellAt(place);
      const auto cover = static_cast<Cover>(truth.cover(cell));
      const auto fault = static_cast<GroundFault>(truth.fault(cell));
      if (cover == Cover::kDoubt || fault == GroundFault::kOutside) continue;
      if (is_inner_meadow(cell)) {
        const bool is_rough = fault == GroundFault::kRough;
        kinds.Set(row, col, is_rough ? "rough_meadow" : "meadow", is_rough ? kOnlyReported : 1.0f);
      } else if (cover != Cover::kMeadow && (is_inner_other(cell) || IsThing(cover))) {
        kinds.Set(row, col, CoverName(cover), 0.0f);
      }
    }
  }
  return kinds.Take();
}

// A labelled photograph and where it was taken from.
struct LabelledView {
  const LabelledPhotograph& photograph;
  Camera camera;
  Rigid3d camera_from_world;

  // 0 where the photograph shows no labelled region.
  uint8_t ClassAt(const Eigen::Vector3d& place_in_world) const {
    const auto pixel = camera.ImageFromCamera(camera_from_world * place_in_world);
    if (!pixel || !camera.IsInside(*pixel)) return 0;
    const double scale = photograph.mask.cols / static_cast<double>(camera.width_px);
    const cv::Point at(static_cast<int>(pixel->x() * scale), static_cast<int>(pixel->y() * scale));
    if (!cv::Rect({}, photograph.mask.size()).contains(at)) return 0;
    const uint8_t shown = photograph.mask(at);
    return shown == kUnlabelledClass || shown == kDormantGrassClass ? uint8_t{0} : shown;
  }
};

std::vector<LabelledView> LabelledViews(const std::string& flight,
                                        const AdjustedBlock& block,
                                        const Photographs& photographs) {
  std::vector<LabelledView> views;
  for (size_t v = 0; v < block.views.size(); ++v) {
    const AdjustedView& view = block.views[v];
    if (!view.is_connected) continue;
    const std::string name = flight + "__" + std::filesystem::path(view.frame_id).stem().string();
    const auto photograph = std::find_if(photographs.begin(),
                                         photographs.end(),
                                         [&](const auto& each) { return each.name == name; });
    if (photograph == photographs.end()) continue;
    views.push_back({*photograph, block.CameraOf(v), Inverse(view.world_from_camera)});
  }
  return views;
}

// The class that all photographs of a place agree on; 0 where none has one.
uint8_t AgreedClass(const std::vector<LabelledView>& views, const Eigen::Vector3d& place) {
  uint8_t agreed = 0;
  for (const LabelledView& view : views) {
    const uint8_t shown = view.ClassAt(place);
    if (shown == 0) continue;
    if (agreed != 0 && agreed != shown) return 0;
    agreed = shown;
  }
  return agreed;
}

// Classes of the labelled regions that all photographs agree on; 0 where none has one.
cv::Mat1b LabelledClasses(const std::filesystem::path& folder, const Evaluation& evaluation) {
  const std::string root = FREELSD_SOURCE_DIR "/tests/evaluation/";
  const Photographs photographs =
      ReadLabelledFlights(folder.parent_path().string(),
                          root + "labels",
                          ReadLabelledCameras(root + "grass_cameras.csv"));
  const std::vector<LabelledView> views =
      LabelledViews(folder.filename().string(), evaluation.block, photographs);
  const ElevationMap& map = evaluation.map;
  cv::Mat1b classes = cv::Mat1b::zeros(map.elevation.size());
  for (int row = 0; row < classes.rows; ++row) {
    for (int col = 0; col < classes.cols; ++col) {
      if (!map.IsSeen(row, col)) continue;
      Eigen::Vector3d place;
      place << map.grid.CellCenter(row, col), map.elevation(row, col);
      classes(row, col) = AgreedClass(views, place);
    }
  }
  return classes;
}

// What outlines show of a place: the most dangerous object, else land; "" where nothing.
std::string OutlinedAt(const LabelledGround& ground, const Eigen::Vector2d& place) {
  const auto cell = ground.grid.CellAt(place);
  if (!cell) return "";
  std::string found;
  for (const LabelledObject& object : ground.objects) {
    if (!object.cells.contains(*cell) || object.mask(*cell - object.cells.tl()) == 0) continue;
    if (object.kind == OutlineKind::kDoubt) return NameOf(OutlineKind::kDoubt);
    if (object.kind == OutlineKind::kLand && !found.empty()) continue;
    if (object.kind == OutlineKind::kRefuse && !found.empty() && found != "land") continue;
    found = NameOf(object.kind);
  }
  return found;
}

constexpr std::array<const char*, 10> kClassNames{"",
                                                  "grass",
                                                  "trees",
                                                  "tall_growth",
                                                  "crops",
                                                  "soil",
                                                  "paved",
                                                  "building",
                                                  "water",
                                                  "dormant_grass"};

// `outlined`: as of OutlinedAt. `shown`: class of a labelled region, or 0.
void SetKind(const std::string& outlined, uint8_t shown, const cv::Point& cell, KindMap& kinds) {
  if (outlined == "doubt") return;
  const bool is_grass = outlined.empty() && shown == kGrassClass;
  if (outlined == "refuse" && shown == kGrassClass) {
    kinds.Set(cell.y, cell.x, "refused_grass", kOnlyReported);
  } else if (outlined == "land" || is_grass) {
    kinds.Set(cell.y, cell.x, is_grass ? "grass" : outlined, 1.0f);
  } else if (!outlined.empty() || shown != 0) {
    kinds.Set(cell.y, cell.x, outlined.empty() ? kClassNames[shown] : outlined, 0.0f);
  }
}

KindRasters LabelledKinds(const std::filesystem::path& folder,
                          const Evaluation& evaluation,
                          const LabelledGround& ground) {
  const cv::Mat1b classes = LabelledClasses(folder, evaluation);
  const Grid& grid = evaluation.map.grid;
  KindMap kinds({grid.num_cols, grid.num_rows});
  for (int row = 0; row < grid.num_rows; ++row) {
    for (int col = 0; col < grid.num_cols; ++col) {
      if (!evaluation.map.IsSeen(row, col)) continue;
      SetKind(OutlinedAt(ground, grid.CellCenter(row, col)), classes(row, col), {col, row}, kinds);
    }
  }
  return kinds.Take();
}

void DrawKinds(const std::string& path, const GroundRun& run, const KindRasters& rasters) {
  cv::Mat3b picture;
  cv::resize(run.photo.image, picture, {}, 0.5, 0.5, cv::INTER_AREA);
  cv::Mat1b kind;
  cv::resize(rasters.kind, kind, picture.size(), 0.0, 0.0, cv::INTER_NEAREST);
  for (int row = 0; row < picture.rows; ++row) {
    for (int col = 0; col < picture.cols; ++col) {
      if (kind(row, col) == 0) continue;
      const float is_fit = rasters.is_fit[static_cast<size_t>(kind(row, col) - 1)];
      const cv::Vec3b color = is_fit > 0.5f    ? cv::Vec3b(0, 255, 0)
                              : is_fit == 0.0f ? cv::Vec3b(0, 0, 255)
                                               : cv::Vec3b(255, 0, 0);
      if ((row + col) % 4 == 0) picture(row, col) = color;
    }
  }
  cv::imwrite(path, picture);
}

void Finish(const std::string& name,
            const GroundRun& run,
            const KindSourceOptions& options,
            KindRasters* rasters) {
  rasters->cues = CuesOf(run, options.engine);
  if (!options.pictures.empty()) DrawKinds(options.pictures + "/" + name + ".png", run, *rasters);
}

}  // namespace

KindRasters KindsOfWorld(uint64_t seed,
                         const ScenarioOptions& scenario_options,
                         const Classifier& classifier,
                         const KindSourceOptions& options) {
  const Scenario scenario = MakeScenario(seed, scenario_options, [](double) {});
  const TruthMap truth = MakeTruthMap(scenario.world, scenario.aircraft);
  const GroundRun run = RunGround(scenario.rig, scenario.frames, classifier, options.engine);
  KindRasters rasters = TrueKinds(run.evaluation.map, truth);
  Finish(scenario_options.ground + scenario_options.texture + "-" + std::to_string(seed),
         run,
         options,
         &rasters);
  return rasters;
}

KindRasters KindsOfFlight(const std::string& folder,
                          const Classifier& classifier,
                          const KindSourceOptions& options) {
  const std::string flight = std::filesystem::path(folder).filename().string();
  const RecordedFrames frames = ReadRecordedFrames(folder);
  const GroundRun run = RunGround(frames.rig, frames.frames, classifier, options.engine);
  const std::string outlines =
      FREELSD_SOURCE_DIR "/tests/evaluation/fields/outlines/" + flight + ".txt";
  const LabelledGround ground =
      LabelledGroundOf(ParseOutlines(ReadTextFile(outlines), outlines), run.evaluation);
  KindRasters rasters = LabelledKinds(folder, run.evaluation, ground);
  Finish(flight, run, options, &rasters);
  return rasters;
}

}  // namespace freelsd
