// The reprojection residual with analytic derivatives. They equal those of automatic
// differentiation, and take a fraction of the time. Computes only the derivatives that the solver
// requests.
#pragma once

#include <ceres/sized_cost_function.h>

#include "engine/adjustment/residuals.h"

namespace freelsd {

// Parameter blocks as in residuals.h.
class ReprojectionCost final
    : public ceres::
          SizedCostFunction<2, kNumPoseParameters, 3, kNumLensParameters, kNumReadoutParameters> {
 public:
  // The camera must outlive this object.
  ReprojectionCost(const Camera* calibrated_camera, const Eigen::Vector2d& sighting)
      : residual_(calibrated_camera, sighting) {}

  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override;

 private:
  ReprojectionResidual residual_;
};

}  // namespace freelsd
