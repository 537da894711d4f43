#include "engine/tracks/attitude/planar_alignment.h"

#include <algorithm>
#include <cmath>
#include <complex>

#include <Eigen/Dense>

#include "engine/tracks/attitude/ground_place.h"

namespace freelsd {
namespace {

using Complex = std::complex<double>;

// Relief and slope shift a match by a few percent of the height; more is an outlier.
constexpr double kMatchSdRatio = 0.03;
// Matches of one pair share errors (relief, lens): together they count as this many.
constexpr double kEffectiveMatchesPerPair = 12.0;
constexpr int kNumLinearIterations = 8;
constexpr int kNumRefinements = 15;
// First guess: height above ground in baselines, because photographs overlap by about half.
constexpr double kFirstHeightPerBaseline = 2.0;
// Heights above ground of neighbours differ as their altitudes do, up to GPS noise and terrain.
constexpr double kHeightDifferenceSdM = 3.0;
constexpr double kHeightDifferenceSdRatio = 0.08;
constexpr double kMinHeightM = 3.0;
constexpr double kMaxHeightM = 3000.0;
constexpr double kMaxTiltDeg = 35.0;
// Frames with a larger median residual, as a share of the height, are not trusted.
constexpr double kMaxMedianResidualRatio = 0.12;
constexpr double kDamping = 1e-9;
// Unknowns of a frame in the refinement: rotation in world (3), log height, position error (2).
constexpr int kNumUnknowns = 6;

Complex SeenFromAbove(const Eigen::Vector2d& point) { return {point.x(), -point.y()}; }
Complex EastNorth(const Eigen::Vector3d& position) { return {position.x(), position.y()}; }

double CauchyWeight(double residual, double scale) {
  const double ratio = residual / scale;
  return 1.0 / (1.0 + ratio * ratio);
}

double PairWeight(const AlignmentPair& pair) {
  return std::min(1.0, kEffectiveMatchesPerPair / static_cast<double>(pair.points_a.size()));
}

double Median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Camera looking down, image top turned by arg(a) from north, nadir offset by c.
Eigen::Quaterniond AttitudeOf(Complex a, Complex c) {
  const double height = std::abs(a);
  const double turn = std::arg(a);
  Eigen::Matrix3d level;
  level << std::cos(turn), std::sin(turn), 0, std::sin(turn), -std::cos(turn), 0, 0, 0, -1;
  const Eigen::Vector3d axis = Eigen::Vector3d(c.real() / height, c.imag() / height, -1.0);
  const Eigen::Quaterniond tilt =
      Eigen::Quaterniond::FromTwoVectors(-Eigen::Vector3d::UnitZ(), axis);
  return (tilt * Eigen::Quaterniond(level)).normalized();
}

// The whole problem: frames, and which of them are unknown.
class GroundAlignment {
 public:
  GroundAlignment(std::vector<AlignmentFrame> frames,
                  const std::vector<AlignmentPair>& pairs,
                  const AlignmentOptions& options)
      : frames_(std::move(frames)), pairs_(pairs), options_(options) {
    for (size_t i = 0; i < frames_.size(); ++i) {
      column_.push_back(frames_[i].is_held ? -1 : num_free_++);
      position_.push_back(frames_[i].position_in_world.head<2>());
    }
  }

  std::vector<AlignmentFrame> Solve() {
    if (num_free_ == 0 || pairs_.empty()) return frames_;
    SolveLinear();
    for (int i = 0; i < kNumRefinements; ++i) {
      if (!Refine()) return frames_;
    }
    Judge();
    return frames_;
  }

 private:
  double MedianHeight() const {
    std::vector<double> heights;
    for (const AlignmentFrame& frame : frames_) {
      if (frame.height_above_ground > 0.0) heights.push_back(frame.height_above_ground);
    }
    return Median(heights);
  }

  double FirstHeight() const {
    std::vector<double> heights, baselines;
    for (const AlignmentFrame& frame : frames_) {
      if (frame.is_held) heights.push_back(frame.height_above_ground);
    }
    if (!heights.empty()) return Median(heights);
    for (const AlignmentPair& pair : pairs_) {
      baselines.push_back((position_[pair.a] - position_[pair.b]).norm());
    }
    return std::max(kMinHeightM, kFirstHeightPerBaseline * Median(baselines));
  }

  // One match in the linear problem: unknown a and c of free frames, place of held ones.
  struct LinearRow {
    int columns[4] = {-1, -1, -1, -1};
    Complex factors[4];
    Complex right_side;
  };

  void AddLinearTerm(LinearRow& row, int slot, size_t index, const Eigen::Vector2d& point) const {
    const double sign = slot == 0 ? 1.0 : -1.0;
    if (frames_[index].is_held) {
      const UnitPlace unit = UnitPlaceOf(frames_[index].world_from_camera, point);
      const Eigen::Vector2d place =
          position_[index] + frames_[index].height_above_ground * unit.place;
      row.right_side -= sign * Complex(place.x(), place.y());
      return;
    }
    row.columns[2 * slot] = 2 * column_[index];
    row.factors[2 * slot] = sign * SeenFromAbove(point);
    row.columns[2 * slot + 1] = 2 * column_[index] + 1;
    row.factors[2 * slot + 1] = sign;
    row.right_side -= sign * EastNorth(frames_[index].position_in_world);
  }

  std::vector<LinearRow> LinearRows() const {
    std::vector<LinearRow> rows;
    for (const AlignmentPair& pair : pairs_) {
      for (size_t i = 0; i < pair.points_a.size(); ++i) {
        LinearRow row;
        AddLinearTerm(row, 0, pair.a, pair.points_a[i]);
        AddLinearTerm(row, 1, pair.b, pair.points_b[i]);
        rows.push_back(row);
      }
    }
    return rows;
  }

  Complex LinearResidual(const LinearRow& row, const Eigen::VectorXcd& unknowns) const {
    Complex residual = -row.right_side;
    for (int k = 0; k < 4; ++k) {
      if (row.columns[k] >= 0) residual += row.factors[k] * unknowns[row.columns[k]];
    }
    return residual;
  }

  Eigen::VectorXcd SolveWeighted(const std::vector<LinearRow>& rows,
                                 const std::vector<double>& weights,
                                 double height) const {
    const int size = 2 * num_free_;
    Eigen::MatrixXcd normal_matrix = Eigen::MatrixXcd::Zero(size, size);
    Eigen::VectorXcd right_side = Eigen::VectorXcd::Zero(size);
    for (size_t r = 0; r < rows.size(); ++r) {
      for (int k = 0; k < 4; ++k) {
        if (rows[r].columns[k] < 0) continue;
        const Complex factor = weights[r] * std::conj(rows[r].factors[k]);
        right_side[rows[r].columns[k]] += factor * rows[r].right_side;
        for (int l = 0; l < 4; ++l) {
          if (rows[r].columns[l] < 0) continue;
          normal_matrix(rows[r].columns[k], rows[r].columns[l]) += factor * rows[r].factors[l];
        }
      }
    }
    for (size_t i = 0; i < frames_.size(); ++i) {
      if (column_[i] < 0) continue;
      const double offset_sd =
          std::hypot(height * std::tan(options_.nadir_sd), frames_[i].position_sd_m);
      normal_matrix(2 * column_[i] + 1, 2 * column_[i] + 1) += 1.0 / (offset_sd * offset_sd);
      normal_matrix(2 * column_[i], 2 * column_[i]) += kDamping;
    }
    return normal_matrix.ldlt().solve(right_side);
  }

  void SolveLinear() {
    const std::vector<LinearRow> rows = LinearRows();
    std::vector<double> pair_weights;
    for (const AlignmentPair& pair : pairs_) {
      pair_weights.insert(pair_weights.end(), pair.points_a.size(), PairWeight(pair));
    }
    double height = FirstHeight();
    std::vector<double> robust(rows.size(), 1.0);
    for (int iteration = 0; iteration < kNumLinearIterations; ++iteration) {
      const double sd = kMatchSdRatio * height;
      std::vector<double> weights(rows.size());
      for (size_t r = 0; r < rows.size(); ++r) {
        weights[r] = pair_weights[r] * robust[r] / (sd * sd);
      }
      const Eigen::VectorXcd unknowns = SolveWeighted(rows, weights, height);
      for (size_t r = 0; r < rows.size(); ++r) {
        robust[r] = CauchyWeight(std::abs(LinearResidual(rows[r], unknowns)), 2.0 * sd);
      }
      TakeLinear(unknowns);
      height = std::clamp(MedianHeight(), kMinHeightM, kMaxHeightM);
    }
  }

  void TakeLinear(const Eigen::VectorXcd& unknowns) {
    for (size_t i = 0; i < frames_.size(); ++i) {
      if (column_[i] < 0) continue;
      const Complex a = unknowns[2 * column_[i]];
      const double height = std::clamp(std::abs(a), kMinHeightM, kMaxHeightM);
      // Limits the offset of the axis to the largest tilt.
      Complex c = unknowns[2 * column_[i] + 1];
      const double max_offset = height * std::tan(RadFromDeg(kMaxTiltDeg) / 2.0);
      if (std::abs(c) > max_offset) c *= max_offset / std::abs(c);
      frames_[i].height_above_ground = height;
      frames_[i].world_from_camera = AttitudeOf(std::polar(height, std::arg(a)), c);
    }
  }

  // Normal equations of one refinement step.
  struct Normal {
    Eigen::MatrixXd matrix;
    Eigen::VectorXd right_side;
  };

  // Adds weight * |residual + sum of jacobian * unknowns|^2 over up to two frames.
  template <int kRows>
  void AddBlock(
      Normal& normal,
      const std::vector<std::pair<int, Eigen::Matrix<double, kRows, kNumUnknowns>>>& parts,
      const Eigen::Matrix<double, kRows, 1>& residual,
      double weight) const {
    for (const auto& [column_a, jacobian_a] : parts) {
      if (column_a < 0) continue;
      const int row = kNumUnknowns * column_a;
      normal.right_side.segment<kNumUnknowns>(row) -= weight * jacobian_a.transpose() * residual;
      for (const auto& [column_b, jacobian_b] : parts) {
        if (column_b < 0) continue;
        normal.matrix.block<kNumUnknowns, kNumUnknowns>(row, kNumUnknowns * column_b) +=
            weight * jacobian_a.transpose() * jacobian_b;
      }
    }
  }

  Eigen::Matrix<double, 2, kNumUnknowns> PlaceJacobian(size_t index, const UnitPlace& unit) const {
    const double height = frames_[index].height_above_ground;
    Eigen::Matrix<double, 2, kNumUnknowns> jacobian;
    jacobian.leftCols<3>() = height * unit.by_rotation;
    jacobian.col(3) = height * unit.place;
    jacobian.rightCols<2>().setIdentity();
    return jacobian;
  }

  std::optional<Eigen::Vector2d> Residual(const AlignmentPair& pair, size_t i) const {
    const UnitPlace a = UnitPlaceOf(frames_[pair.a].world_from_camera, pair.points_a[i]);
    const UnitPlace b = UnitPlaceOf(frames_[pair.b].world_from_camera, pair.points_b[i]);
    if (!a.is_below_horizon || !b.is_below_horizon) return std::nullopt;
    return position_[pair.a] + frames_[pair.a].height_above_ground * a.place - position_[pair.b] -
           frames_[pair.b].height_above_ground * b.place;
  }

  void AddMatches(Normal& normal, const AlignmentPair& pair) const {
    const double height =
        0.5 * (frames_[pair.a].height_above_ground + frames_[pair.b].height_above_ground);
    const double sd = kMatchSdRatio * height;
    for (size_t i = 0; i < pair.points_a.size(); ++i) {
      const std::optional<Eigen::Vector2d> residual = Residual(pair, i);
      if (!residual) continue;
      const UnitPlace a = UnitPlaceOf(frames_[pair.a].world_from_camera, pair.points_a[i]);
      const UnitPlace b = UnitPlaceOf(frames_[pair.b].world_from_camera, pair.points_b[i]);
      const double weight = PairWeight(pair) * CauchyWeight(residual->norm(), sd) / (sd * sd);
      AddBlock<2>(normal,
                  {{column_[pair.a], PlaceJacobian(pair.a, a)},
                   {column_[pair.b], -PlaceJacobian(pair.b, b)}},
                  *residual,
                  weight);
    }
    AddHeightDifference(normal, pair, height);
  }

  // Both frames see the same level ground.
  void AddHeightDifference(Normal& normal, const AlignmentPair& pair, double height) const {
    const AlignmentFrame &a = frames_[pair.a], &b = frames_[pair.b];
    Eigen::Matrix<double, 1, kNumUnknowns> of_a, of_b;
    of_a.setZero();
    of_b.setZero();
    of_a(0, 3) = -a.height_above_ground;
    of_b(0, 3) = b.height_above_ground;
    const Eigen::Matrix<double, 1, 1> residual((a.position_in_world.z() - a.height_above_ground) -
                                               (b.position_in_world.z() - b.height_above_ground));
    const double sd = std::hypot(kHeightDifferenceSdM, kHeightDifferenceSdRatio * height);
    AddBlock<1>(
        normal, {{column_[pair.a], of_a}, {column_[pair.b], of_b}}, residual, 1.0 / (sd * sd));
  }

  void AddPriors(Normal& normal, size_t index) const {
    const AlignmentFrame& frame = frames_[index];
    const Eigen::Vector3d axis = frame.world_from_camera * Eigen::Vector3d::UnitZ();
    Eigen::Matrix<double, 2, kNumUnknowns> of_tilt, of_position;
    of_tilt.setZero();
    of_tilt.leftCols<3>() = -CrossMatrix(axis).topRows<2>();
    of_position.setZero();
    of_position.rightCols<2>().setIdentity();
    AddBlock<2>(normal,
                {{column_[index], of_tilt}},
                axis.head<2>(),
                1.0 / (options_.nadir_sd * options_.nadir_sd));
    AddBlock<2>(normal,
                {{column_[index], of_position}},
                position_[index] - frame.position_in_world.head<2>(),
                1.0 / (frame.position_sd_m * frame.position_sd_m));
  }

  bool Refine() {
    const int size = kNumUnknowns * num_free_;
    Normal normal{Eigen::MatrixXd::Zero(size, size), Eigen::VectorXd::Zero(size)};
    for (const AlignmentPair& pair : pairs_) AddMatches(normal, pair);
    for (size_t i = 0; i < frames_.size(); ++i) {
      if (column_[i] >= 0) AddPriors(normal, i);
    }
    normal.matrix.diagonal().array() += kDamping;
    const Eigen::LDLT<Eigen::MatrixXd> solver(normal.matrix);
    const Eigen::VectorXd step = solver.solve(normal.right_side);
    if (!step.allFinite()) return false;
    const Eigen::MatrixXd covariance = solver.solve(Eigen::MatrixXd::Identity(size, size));
    for (size_t i = 0; i < frames_.size(); ++i) {
      if (column_[i] < 0) continue;
      const int row = kNumUnknowns * column_[i];
      TakeStep(i, step.segment<kNumUnknowns>(row));
      frames_[i].heading_sd = std::sqrt(std::max(0.0, covariance(row + 2, row + 2)));
    }
    return true;
  }

  void TakeStep(size_t index, const Eigen::Matrix<double, kNumUnknowns, 1>& step) {
    constexpr double kMaxTurn = 0.3;
    constexpr double kMaxGrowth = 0.3;
    AlignmentFrame& frame = frames_[index];
    Eigen::Vector3d turn = step.head<3>();
    if (turn.norm() > kMaxTurn) turn *= kMaxTurn / turn.norm();
    if (turn.norm() > 0.0) {
      frame.world_from_camera =
          (Eigen::AngleAxisd(turn.norm(), turn.normalized()) * frame.world_from_camera)
              .normalized();
    }
    frame.height_above_ground = std::clamp(
        frame.height_above_ground * std::exp(std::clamp(step[3], -kMaxGrowth, kMaxGrowth)),
        kMinHeightM,
        kMaxHeightM);
    position_[index] += step.tail<2>();
  }

  void Judge() {
    for (size_t i = 0; i < frames_.size(); ++i) {
      if (column_[i] < 0) continue;
      AlignmentFrame& frame = frames_[i];
      std::vector<double> residuals;
      for (const AlignmentPair& pair : pairs_) {
        if (pair.a != i && pair.b != i) continue;
        for (size_t k = 0; k < pair.points_a.size(); ++k) {
          const std::optional<Eigen::Vector2d> residual = Residual(pair, k);
          residuals.push_back(residual ? residual->norm() : kMaxHeightM);
        }
      }
      const Eigen::Vector3d axis = frame.world_from_camera * Eigen::Vector3d::UnitZ();
      const double max_residual = kMaxMedianResidualRatio * frame.height_above_ground;
      frame.is_solved = !residuals.empty() && Median(residuals) < max_residual &&
                        -axis.z() > std::cos(RadFromDeg(kMaxTiltDeg)) &&
                        frame.heading_sd < options_.max_heading_sd &&
                        frame.height_above_ground > 1.01 * kMinHeightM &&
                        frame.height_above_ground < 0.99 * kMaxHeightM;
      frame.position_in_world.head<2>() = position_[i];
    }
  }

  std::vector<AlignmentFrame> frames_;
  const std::vector<AlignmentPair>& pairs_;
  AlignmentOptions options_;
  std::vector<int> column_;
  int num_free_ = 0;
  // Best horizontal positions so far.
  std::vector<Eigen::Vector2d> position_;
};

}  // namespace

std::vector<AlignmentFrame> AlignToGround(std::vector<AlignmentFrame> frames,
                                          const std::vector<AlignmentPair>& pairs,
                                          const AlignmentOptions& options) {
  return GroundAlignment(std::move(frames), pairs, options).Solve();
}

}  // namespace freelsd
