// SPDX-License-Identifier: MIT
#include "demos/runner/trajectory_table.h"

#include "bullet_bridge/convert.h"

namespace granular_demo {

TrajectoryTables::TrajectoryTables(const BuiltScene& scene, const std::filesystem::path& folder)
    : scene_(scene) {
  for (const std::string& name : scene.def().outputs.trajectoryBodies) {
    const btRigidBody* body = scene.body(name).body.get();
    follow(folder / ("trajectory_body_" + name + ".csv"), [body] {
      using bullet_bridge::fromBullet;
      return granular::RigidMotion{fromBullet(body->getWorldTransform()),
                                   fromBullet(body->getLinearVelocity()),
                                   fromBullet(body->getAngularVelocity())};
    });
  }
  for (const std::string& name : scene.def().outputs.trajectoryGrains) {
    const std::int32_t index = scene.grain(name).index;
    follow(folder / ("trajectory_grain_" + name + ".csv"),
           [&scene, index] { return scene.grains().grainMotions()[index]; });
  }
}

void TrajectoryTables::follow(const std::filesystem::path& file,
                              std::function<granular::RigidMotion()> motion) {
  const std::vector<std::string> columns = {"time", "x",  "y",  "z",  "vx", "vy", "vz",
                                            "qw",   "qx", "qy", "qz", "wx", "wy", "wz"};
  tables_.push_back({std::move(motion), CsvFile(file, columns)});
  files_.push_back(file);
}

void TrajectoryTables::add() {
  for (Table& table : tables_) {
    const granular::RigidMotion m = table.motion();
    const Vector3& x = m.pose.position;
    const Quaternion& q = m.pose.orientation;
    table.csv.row({scene_.time(), x.x(), x.y(), x.z(), m.velocity.x(), m.velocity.y(), m.velocity.z(), q.w(),
                   q.x(), q.y(), q.z(), m.angularVelocity.x(), m.angularVelocity.y(), m.angularVelocity.z()});
  }
}

}  // namespace granular_demo
