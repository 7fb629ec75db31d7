// SPDX-License-Identifier: MIT
// The way of one grain or body: a CSV file with a row a tick.
// Columns: time,x,y,z,vx,vy,vz,qw,qx,qy,qz,wx,wy,wz (s, m, m/s, orientation of the principal frame, rad/s;
// world).
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "demos/runner/csv_file.h"
#include "demos/world/built_scene.h"

namespace granular_demo {

/// Files trajectory_<name>.csv for all that the scene asks for.
class TrajectoryTables {
 public:
  /// `scene` must outlive this.
  TrajectoryTables(const BuiltScene& scene, const std::filesystem::path& folder);
  void add();  ///< a row of the state as it stands
  const std::vector<std::filesystem::path>& files() const { return files_; }

 private:
  struct Table {
    std::function<granular::RigidMotion()> motion;
    CsvFile csv;
  };

  void follow(const std::filesystem::path& file, std::function<granular::RigidMotion()> motion);

  const BuiltScene& scene_;
  std::vector<Table> tables_;
  std::vector<std::filesystem::path> files_;
};

}  // namespace granular_demo
