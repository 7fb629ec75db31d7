// SPDX-License-Identifier: MIT
#include "demos/render/render_scene.h"

namespace granular_demo {

Box boundsOf(const RenderScene& scene) {
  Eigen::AlignedBox3d bounds;
  for (const RenderSphere& sphere : scene.spheres) {
    bounds.extend(Vector3(sphere.position.array() - sphere.radius));
    bounds.extend(Vector3(sphere.position.array() + sphere.radius));
  }
  for (const MeshInstance& instance : scene.meshes) {
    if (!instance.mesh) continue;
    for (const Vector3& vertex : instance.mesh->vertices) bounds.extend(instance.pose.toWorld(vertex));
  }
  if (bounds.isEmpty()) return {Vector3::Constant(-0.5), Vector3::Constant(0.5)};
  return {bounds.min(), bounds.max()};
}

}  // namespace granular_demo
