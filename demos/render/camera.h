// SPDX-License-Identifier: MIT
// A pinhole camera, where it puts a point on the picture, and how to stand it in front of a box.
#pragma once

#include "granular/base/pose.h"

namespace granular_demo {

struct Camera {
  granular::Vector3 eye = granular::Vector3(0, 1, 3);    ///< m
  granular::Vector3 target = granular::Vector3::Zero();  ///< m, shown in the middle of the picture
  granular::Vector3 up = granular::Vector3::UnitY();     ///< not along the view
  double verticalFieldOfViewDegrees = 35.0;              ///< (0, 170)
};

/// Axes of the camera (unit, world frame) and half the picture's extent at distance 1.
struct CameraFrame {
  granular::Vector3 right, up, forward;
  double halfWidth = 0.0, halfHeight = 0.0;

  /// @throws std::invalid_argument for a camera that looks nowhere, or sizes that are not > 0
  CameraFrame(const Camera& camera, int width, int height);
};

/// Where a point lands, in pixels: (0, 0) is the upper left corner of the upper left pixel, y points down.
/// The point must lie in front of the camera.
Eigen::Vector2d projectToPixel(const Camera& camera, int width, int height, const granular::Vector3& point);

/// A camera that sees the whole box with a little room around it.
///
/// @param viewDirection  from the camera into the scene; any length > 0
/// @param aspect         width / height of the picture
/// @param margin         1 fits exactly; 1.1 leaves a tenth of room
Camera frameBox(const granular::Box& box, double aspect,
                const granular::Vector3& viewDirection = granular::Vector3(-0.35, -0.38, -1.0),
                const granular::Vector3& up = granular::Vector3::UnitY(),
                double verticalFieldOfViewDegrees = 30.0, double margin = 1.04);

}  // namespace granular_demo
