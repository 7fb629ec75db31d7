// SPDX-License-Identifier: MIT
#include "demos/render/camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "granular/base/require.h"

namespace granular_demo {

using granular::Vector3;

CameraFrame::CameraFrame(const Camera& camera, int width, int height) {
  granular::require(width > 0 && height > 0, "Picture size",
                    std::to_string(width) + " x " + std::to_string(height), "pixels", "> 0 both ways");
  granular::requireFinite(camera.eye, "Camera.eye", "m");
  granular::requireFinite(camera.target, "Camera.target", "m");
  const double angle = camera.verticalFieldOfViewDegrees;
  granular::require(angle > 0.0 && angle < 170.0, "Camera.verticalFieldOfViewDegrees", angle, "degrees",
                    "in (0, 170)");
  const Vector3 view = camera.target - camera.eye;
  granular::requirePositive(view.norm(), "Distance from Camera.eye to Camera.target", "m");
  forward = view.normalized();
  const Vector3 side = forward.cross(camera.up);
  granular::require(side.norm() > 1e-9 * camera.up.norm(), "Camera.up", camera.up.transpose(), "",
                    "finite, not zero and not along the view");
  right = side.normalized();
  up = right.cross(forward);
  halfHeight = std::tan(0.5 * angle * std::numbers::pi / 180.0);
  halfWidth = halfHeight * width / height;
}

Eigen::Vector2d projectToPixel(const Camera& camera, int width, int height, const Vector3& point) {
  const CameraFrame frame(camera, width, height);
  const Vector3 ray = point - camera.eye;
  const double depth = ray.dot(frame.forward);
  const double x = ray.dot(frame.right) / (depth * frame.halfWidth);
  const double y = ray.dot(frame.up) / (depth * frame.halfHeight);
  return {0.5 * (1.0 + x) * width, 0.5 * (1.0 - y) * height};
}

Camera frameBox(const granular::Box& box, double aspect, const Vector3& viewDirection, const Vector3& up,
                double verticalFieldOfViewDegrees, double margin) {
  granular::requirePositive(aspect, "Picture aspect", "");
  granular::requirePositive(margin, "Camera margin", "");
  Camera camera{.eye = box.center() - viewDirection,
                .target = box.center(),
                .up = up,
                .verticalFieldOfViewDegrees = verticalFieldOfViewDegrees};
  CameraFrame frame(camera, 1, 1);
  frame.halfWidth = frame.halfHeight * aspect;
  // The nearest distance at which each corner is still inside the pyramid of sight.
  double distance = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vector3 sign((corner & 1) ? 1 : -1, (corner & 2) ? 1 : -1, (corner & 4) ? 1 : -1);
    const Vector3 arm = 0.5 * sign.cwiseProduct(box.size());
    const double sideways = std::max(std::abs(arm.dot(frame.right)) / frame.halfWidth,
                                     std::abs(arm.dot(frame.up)) / frame.halfHeight);
    distance = std::max(distance, margin * sideways - arm.dot(frame.forward));
  }
  granular::requirePositive(distance, "Diagonal of the box to frame", "m");
  camera.eye = camera.target - distance * frame.forward;
  return camera;
}

}  // namespace granular_demo
