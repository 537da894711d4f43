#include <algorithm>
#include <cmath>
#include <utility>

#include <opencv2/dnn.hpp>
#include <opencv2/imgproc.hpp>

#include "engine/ground_kind/kind_model.h"

namespace freelsd {
namespace {

// Weights of blue, green and red in luma.
const cv::Vec3d kLumaWeights(0.114, 0.587, 0.299);
// Keeps ratios of colours finite.
constexpr double kLeastColour = 0.02;
// Luma of a dark photograph is that of every fourth pixel of every fourth row.
constexpr int kLumaStep = 4;
constexpr float kMostSureLogit = 14.0f;
constexpr float kNumProbabilitySteps = 15.0f;

// No picture of the training was coarser, with the largest of its scales.
constexpr double kCoarsestSamplingM = 0.6;
// Of the picture that the network gets: a gigabyte of its layers.
constexpr double kMostPixels = 16e6;
// A photograph of more ground is called coarser, at most by the largest scale of the training.
constexpr double kMostCoarsening = 1.4;

cv::Mat3b Resampled(const cv::Mat& photograph, double scale) {
  cv::Mat3b colour;
  if (photograph.channels() == 1) {
    cv::cvtColor(photograph, colour, cv::COLOR_GRAY2BGR);
  } else {
    colour = photograph;
  }
  const cv::Size size(std::max(8, static_cast<int>(std::lround(colour.cols * scale))),
                      std::max(8, static_cast<int>(std::lround(colour.rows * scale))));
  cv::Mat3b resampled;
  cv::resize(colour, resampled, size, 0.0, 0.0, scale < 1.0 ? cv::INTER_AREA : cv::INTER_CUBIC);
  return resampled;
}

// Dark photographs lie outside of what the training saw.
cv::Mat3b Brightened(const cv::Mat3b& image, const KindModel::Content& model) {
  double sum = 0.0;
  int count = 0;
  for (int row = 0; row < image.rows; row += kLumaStep) {
    for (int col = 0; col < image.cols; col += kLumaStep, ++count) {
      sum += cv::Vec3d(image(row, col)).dot(kLumaWeights);
    }
  }
  const double luma = sum / count;
  if (luma >= model.dark_luma) return image;
  const double gain = std::min(model.brightened_luma / std::max(luma, 1.0), model.largest_gain);
  cv::Mat3b bright(image.size());
  // Cut, not rounded, as in the training.
  std::transform(image.begin(), image.end(), bright.begin(), [gain](const cv::Vec3b& pixel) {
    cv::Vec3b brighter;
    for (int i = 0; i < 3; ++i) {
      brighter[i] = static_cast<uint8_t>(std::min(255.0, pixel[i] * gain));
    }
    return brighter;
  });
  return bright;
}

// Mean and deviation of luma, logarithms of green to red and green to blue, mean saturation.
ColourStatistics StatisticsOf(const cv::Mat3b& image) {
  cv::Vec3d sum;
  double luma_sum = 0.0, luma_squares = 0.0, saturation_sum = 0.0;
  for (const cv::Vec3b& pixel : image) {
    const cv::Vec3d color = cv::Vec3d(pixel) / 255.0;
    const double luma = color.dot(kLumaWeights);
    const auto [least, most] = std::minmax({color[0], color[1], color[2]});
    sum += color;
    luma_sum += luma;
    luma_squares += luma * luma;
    saturation_sum += (most - least) / (most + kLeastColour);
  }
  const auto count = static_cast<double>(image.total());
  const cv::Vec3d mean = sum / count + cv::Vec3d::all(kLeastColour);
  const double mean_luma = luma_sum / count;
  const double variance = std::max(0.0, luma_squares / count - mean_luma * mean_luma);
  return {mean_luma,
          std::sqrt(variance),
          std::log(mean[1] / mean[2]),
          std::log(mean[1] / mean[0]),
          saturation_sum / count};
}

bool IsLikeTraining(const cv::Mat3b& image, const KindModel::Content& model) {
  const ColourStatistics off = StatisticsOf(image) - model.mean_colours;
  return off.dot(model.inverse_covariance * off) <= model.largest_distance * model.largest_distance;
}

cv::Mat3b Padded(const cv::Mat3b& image, const KindModel::Content& model) {
  const auto far_border = [&](int length) {
    const int whole = length + 2 * model.border_px;
    return model.border_px +
           (model.multiple_of_px - whole % model.multiple_of_px) % model.multiple_of_px;
  };
  const int bottom = far_border(image.rows), right = far_border(image.cols);
  const bool is_small = std::min(image.rows, image.cols) <= std::max(bottom, right);
  cv::Mat3b padded;
  cv::copyMakeBorder(image,
                     padded,
                     model.border_px,
                     bottom,
                     model.border_px,
                     right,
                     is_small ? cv::BORDER_REFLECT : cv::BORDER_REFLECT_101);
  return padded;
}

using Probabilities = std::array<float, kNumGroundKinds>;

Probabilities Softmax(const Probabilities& logits) {
  const float largest = *std::max_element(logits.begin(), logits.end());
  Probabilities shares;
  float sum = 0.0f;
  for (size_t i = 0; i < shares.size(); ++i) sum += shares[i] = std::exp(logits[i] - largest);
  for (float& share : shares) share /= sum;
  return shares;
}

float CalibratedGrass(const Probabilities& shares, const KindModel::Content& model) {
  const float logit =
      std::clamp(std::log(shares[0]) - std::log1p(-shares[0]), -kMostSureLogit, kMostSureLogit);
  const double odds = model.platt_scale * static_cast<double>(logit) + model.platt_shift;
  return static_cast<float>(std::min(1.0 / (1.0 + std::exp(-odds)), model.largest_probability));
}

// The other kinds share what is not grass as before.
LikelyKind LikeliestOther(const Probabilities& shares, float grass) {
  const auto likeliest = std::max_element(shares.begin() + 1, shares.end());
  const float rest = std::max(1.0f - shares[0], 1e-6f);
  return {static_cast<GroundKind>(likeliest - shares.begin()), *likeliest / rest * (1.0f - grass)};
}

}  // namespace

uint8_t LikelyKind::Packed() const {
  const auto step = static_cast<int>(std::clamp(probability, 0.0f, 1.0f) * kNumProbabilitySteps);
  return static_cast<uint8_t>(16 * static_cast<int>(kind) + step);
}

LikelyKind LikelyKind::Unpack(uint8_t packed) {
  return {static_cast<GroundKind>(packed / 16),
          static_cast<float>(packed % 16) / kNumProbabilitySteps};
}

struct KindNetwork::State {
  KindModel model;
  cv::dnn::Net net;
};

KindNetwork::KindNetwork(const KindModel& model)
    : state_(std::make_unique<State>(State{
          model,
          cv::dnn::readNetFromONNX(model.content().onnx.data(), model.content().onnx.size())})) {
  state_->net.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
  state_->net.setPreferableTarget(cv::dnn::DNN_TARGET_CPU);
}
KindNetwork::~KindNetwork() = default;
KindNetwork::KindNetwork(KindNetwork&&) noexcept = default;
KindNetwork& KindNetwork::operator=(KindNetwork&&) noexcept = default;

KindPicture KindNetwork::Tell(const cv::Mat& photograph, double ground_sampling_distance_m) {
  const KindModel::Content& model = state_->model.content();
  const double wanted_scale = ground_sampling_distance_m / model.metres_per_pixel;
  const double scale =
      std::min(wanted_scale, std::sqrt(kMostPixels / static_cast<double>(photograph.total())));
  const bool is_within =
      ground_sampling_distance_m <= kCoarsestSamplingM && wanted_scale <= kMostCoarsening * scale;
  if (!is_within) return {cv::Mat1b::zeros(1, 1), cv::Mat1b::zeros(1, 1), double(photograph.cols)};
  const cv::Mat3b image = Brightened(Resampled(photograph, scale), model);
  const int num_rows = (image.rows + model.stride_px - 1) / model.stride_px;
  const int num_cols = (image.cols + model.stride_px - 1) / model.stride_px;
  KindPicture picture{cv::Mat1b::zeros(num_rows, num_cols),
                      cv::Mat1b::zeros(num_rows, num_cols),
                      model.stride_px * photograph.cols / static_cast<double>(image.cols)};
  if (!IsLikeTraining(image, model)) return picture;
  state_->net.setInput(cv::dnn::blobFromImage(
      Padded(image, model), 1.0 / model.scale, {}, cv::Scalar::all(model.offset)));
  const cv::Mat logits = state_->net.forward();
  const int first = model.border_px / model.stride_px;
  for (int row = 0; row < num_rows; ++row) {
    for (int col = 0; col < num_cols; ++col) {
      Probabilities at;
      for (int kind = 0; kind < kNumGroundKinds; ++kind) {
        const int place[] = {0, kind, first + row, first + col};
        at[static_cast<size_t>(kind)] = logits.at<float>(place);
      }
      at = Softmax(at);
      const float grass = CalibratedGrass(at, model);
      picture.grass(row, col) = static_cast<uint8_t>(1 + std::lround(254.0f * grass));
      picture.other(row, col) = LikeliestOther(at, grass).Packed();
    }
  }
  return picture;
}

}  // namespace freelsd
