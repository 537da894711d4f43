// The network that the service uses, on photographs that no training saw.
#include "engine/ground_kind/ground_kind.h"

#include <doctest/doctest.h>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

const std::string kFile = FREELSD_SOURCE_DIR "/engine/ground_kind/ground_kind.onnx";

KindModel Model() { return std::get<KindModel>(ReadGroundModel(kFile).model); }

// Green and uneven, as a lawn from far above.
cv::Mat3b Lawn(int width_px, int height_px) {
  cv::Mat3b image(height_px, width_px);
  cv::RNG random(7);
  random.fill(image, cv::RNG::NORMAL, cv::Scalar(62, 128, 104), cv::Scalar(12, 16, 14));
  cv::GaussianBlur(image, image, {}, 1.5);
  return image;
}

int NumTold(const KindPicture& picture) { return cv::countNonZero(picture.grass); }

TEST_CASE("ground kinds: every 0.6 m of a photograph is told, whatever its sampling") {
  KindNetwork network(Model());
  for (const double sampling_m : {0.05, 0.15, 0.3}) {
    const KindPicture picture = network.Tell(Lawn(400, 300), sampling_m);
    CHECK(NumTold(picture) == picture.grass.rows * picture.grass.cols);
    CHECK(picture.image_px_per_px * sampling_m == doctest::Approx(0.6).epsilon(0.03));
    CHECK(picture.other.size() == picture.grass.size());
  }
}

TEST_CASE("ground kinds: what is too coarse, too wide or of other colours is not told") {
  KindNetwork network(Model());
  CHECK(NumTold(network.Tell(Lawn(400, 300), 0.7)) == 0);
  // A height that is wrong by kilometres would enlarge the photograph a thousand times.
  CHECK(NumTold(network.Tell(Lawn(400, 300), 30.0)) == 0);
  // 2.3 square kilometres at once.
  CHECK(NumTold(network.Tell(Lawn(3000, 3000), 0.5)) == 0);
  cv::Mat3b magenta(300, 400, cv::Vec3b(255, 0, 255));
  CHECK(NumTold(network.Tell(magenta, 0.15)) == 0);
}

TEST_CASE("ground kinds: the same bytes on any number of threads") {
  const int num_threads = cv::getNumThreads();
  const auto told_by = [](int count) {
    cv::setNumThreads(count);
    KindNetwork network(Model());
    return network.Tell(Lawn(376, 240), 0.2);
  };
  const KindPicture one = told_by(1), two = told_by(2);
  cv::setNumThreads(num_threads);
  CHECK(cv::countNonZero(one.grass != two.grass) == 0);
  CHECK(cv::countNonZero(one.other != two.other) == 0);
}

TEST_CASE("ground kinds: a kind and its probability fit a byte") {
  for (int kind = 0; kind < kNumGroundKinds; ++kind) {
    for (const float probability : {0.0f, 0.4f, 1.0f}) {
      const LikelyKind packed{static_cast<GroundKind>(kind), probability};
      const LikelyKind read = LikelyKind::Unpack(packed.Packed());
      CHECK(read.kind == packed.kind);
      CHECK(read.probability == doctest::Approx(probability));
    }
  }
}

TEST_CASE("ground kinds: a file that is no model, or a card of other kinds, is refused") {
  CHECK_THROWS_AS(ReadGroundModel("absent.onnx"), std::invalid_argument);
  CHECK_THROWS_AS(KindModel::Parse("no network", "{}"), std::invalid_argument);
  CHECK_THROWS_AS(KindModel::Parse("", R"({"kinds": ["grass"]})"), std::invalid_argument);
}

}  // namespace
}  // namespace freelsd
