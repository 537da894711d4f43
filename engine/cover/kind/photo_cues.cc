#include <algorithm>
#include <cmath>
#include <limits>

#include <opencv2/imgproc.hpp>

#include "engine/cover/kind/cue_groups.h"
#include "engine/cover/photo_bands.h"
#include "engine/cover/photo_features.h"
#include "engine/geometry/geometry.h"

namespace freelsd {
namespace {

// Added to the sum of the three channels before its logarithm: the noise of a dark pixel.
constexpr float kDarkNoise = 12.0f;
// No ground is more even: keeps the logarithm of a deviation finite.
constexpr float kLeastDeviation = 1e-3f;
// Bands of detail: deviations of the blurs between which it lies, and side of the square it is
// averaged over.
struct Band {
  double fine_m;
  double coarse_m;
  double side_m;
};
constexpr Band kDetailBand{0.0, 0.5, 3.0};
constexpr Band kTuftBand{0.5, 1.5, 7.0};
// A cell's darkest part is compared with this square around it.
constexpr double kShadowSideM = 11.0;
// Side of the square that a cell's greenness is compared with.
constexpr double kSurroundingsM = 61.0;
// The blurs end at four deviations; half of a square is added. No cue reads farther.
constexpr double kDetailHaloM = 12.0;

struct Planes {
  cv::Mat1f log_brightness;
  cv::Mat1f greenness;
};

Planes PlanesOf(const Orthophoto& photo) {
  Planes planes{cv::Mat1f(photo.image.size()), cv::Mat1f(photo.image.size())};
  for (int row = 0; row < photo.image.rows; ++row) {
    for (int col = 0; col < photo.image.cols; ++col) {
      const cv::Vec3b& bgr = photo.image(row, col);
      const float sum = static_cast<float>(bgr[0] + bgr[1] + bgr[2]);
      planes.log_brightness(row, col) = std::log(sum + kDarkNoise);
      planes.greenness(row, col) = (3.0f * bgr[1] - sum) / (sum + kDarkNoise);
    }
  }
  return planes;
}

// Blur over the seen pixels alone.
class SeenBlur {
 public:
  SeenBlur(const cv::Mat1b& is_seen, double cell_size_m) : cell_(cell_size_m) {
    is_seen.convertTo(seen_, CV_32F, 1.0 / 255.0);
  }
  cv::Mat1f Of(const cv::Mat1f& values, double deviation_m) const {
    if (deviation_m <= 0.0) return values;
    cv::Mat1f sum, weight;
    cv::GaussianBlur(values.mul(seen_), sum, {}, deviation_m / cell_);
    cv::GaussianBlur(seen_, weight, {}, deviation_m / cell_);
    return sum / cv::max(weight, 1e-6);
  }
  cv::Mat1f Box(const cv::Mat1f& values, double side_m) const {
    const int side = BoxSide(side_m / cell_);
    const cv::Mat1f weight = BoxMean(seen_, side, BoxBorder::kNothing);
    return BoxMean(values.mul(seen_), side, BoxBorder::kNothing) / cv::max(weight, 1e-6);
  }
  // Logarithm of the deviation of detail in a band.
  cv::Mat1f LogDeviation(const cv::Mat1f& values, const Band& band) const {
    const cv::Mat1f detail = Of(values, band.fine_m) - Of(values, band.coarse_m);
    cv::Mat1f deviation;
    cv::sqrt(Box(detail.mul(detail), band.side_m), deviation);
    cv::log(deviation + kLeastDeviation, deviation);
    return deviation;
  }

 private:
  double cell_;
  cv::Mat1f seen_;
};

// Cues that need the orthophoto's own resolution, as rasters of map cells.
struct DetailCues {
  cv::Mat1f detail;
  cv::Mat1f tuft_texture;
  cv::Mat1f green_texture;
  cv::Mat1f shadow;
};

DetailCues DetailCuesOf(const Orthophoto& photo, const Grid& grid) {
  const Planes planes = PlanesOf(photo);
  const SeenBlur blur(photo.seen, photo.grid.cell_size_m);
  DetailCues cues;
  cues.detail = MeanOnMap(blur.LogDeviation(planes.log_brightness, kDetailBand), photo, grid);
  cues.tuft_texture = MeanOnMap(blur.LogDeviation(planes.log_brightness, kTuftBand), photo, grid);
  cues.green_texture = MeanOnMap(blur.LogDeviation(planes.greenness, kDetailBand), photo, grid);
  cv::Mat1f darkest;
  const int parts = BoxSide(1.0 / photo.grid.cell_size_m);
  cv::erode(planes.log_brightness, darkest, cv::Mat1b::ones(parts, parts));
  cues.shadow = MeanOnMap(darkest - blur.Box(planes.log_brightness, kShadowSideM), photo, grid);
  return cues;
}

Orthophoto PartOf(const Orthophoto& photo, const cv::Range& rows) {
  Orthophoto part;
  part.grid = photo.grid;
  part.image = photo.image.rowRange(rows);
  part.seen = photo.seen.rowRange(rows);
  return part;
}

// Band by band: several rasters of floats of the whole orthophoto would take more memory than all
// else.
DetailCues DetailCuesInBands(const CueInput& input) {
  const Grid& grid = input.map.grid;
  const cv::Size size(grid.num_cols, grid.num_rows);
  DetailCues cues{cv::Mat1f(size), cv::Mat1f(size), cv::Mat1f(size), cv::Mat1f(size)};
  const int halo = static_cast<int>(std::ceil(kDetailHaloM / grid.cell_size_m));
  for (const MapBand& band : MapBandsOf(input.photo, grid)) {
    const MapBand grown = Grown(band, halo, grid);
    Grid grid_of_band = grid;
    grid_of_band.num_rows = grown.map_rows.size();
    const DetailCues found = DetailCuesOf(PartOf(input.photo, grown.photo_rows), grid_of_band);
    const cv::Range own = band.map_rows, in_band = own - grown.map_rows.start;
    found.detail.rowRange(in_band).copyTo(cues.detail.rowRange(own));
    found.tuft_texture.rowRange(in_band).copyTo(cues.tuft_texture.rowRange(own));
    found.green_texture.rowRange(in_band).copyTo(cues.green_texture.rowRange(own));
    found.shadow.rowRange(in_band).copyTo(cues.shadow.rowRange(own));
  }
  return cues;
}

}  // namespace

void VisitPhotoCues(const CueInput& input, const CueVisitor& visit) {
  const ColorsOnMap on_map = ColorsOfMap(input.photo, input.map.grid);
  cv::Mat1f greenness = on_map.colors[0];
  greenness.setTo(std::numeric_limits<float>::quiet_NaN(), on_map.is_seen == 0);
  visit(Cue::kGreennessContrast,
        greenness - KnownMean(greenness, kSurroundingsM / input.map.grid.cell_size_m));
  const DetailCues cues = DetailCuesInBands(input);
  visit(Cue::kDetail, cues.detail);
  visit(Cue::kTuftTexture, cues.tuft_texture);
  visit(Cue::kGreenTexture, cues.green_texture);
  visit(Cue::kShadow, cues.shadow);
}

}  // namespace freelsd
