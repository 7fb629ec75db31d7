// SPDX-License-Identifier: MIT
// Particles as VTK PolyData files (.vtp) and a series of them (.pvd), which ParaView, VisIt and vtk read.
// Format: the "XML file formats" chapter of the VTK User's Guide; data appended raw, so a file is as large as
// its numbers and is written in one go.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "granular/system/granular_system.h"

namespace granular {

/// Points with numbers on them. Arrays that are not empty must be as long as `positions`.
struct PointCloud {
  std::vector<Vector3> positions;       ///< m
  std::vector<double> radius;           ///< m
  std::vector<Vector3> velocity;        ///< of the particle's centre, m/s
  std::vector<std::int32_t> ownerKind;  ///< 0 grain, 1 body (OwnerKind)
  std::vector<std::int32_t> owner;      ///< GrainId::index or BodyId::index
  std::vector<std::int32_t> material;   ///< MaterialId::index
};

/// A body whose particles go into the file; the system does not keep a list of its bodies for others.
struct CloudBody {
  BodyId id;
  MaterialId material;
};

/// All particles of a system, grains first, in the order of GranularSystem::readParticles. Particles of
/// bodies that are not listed are left out.
PointCloud particleCloud(const GranularSystem& system, std::span<const CloudBody> bodies);

/// Writes the cloud as PolyData with one vertex cell a point; empty arrays are left out.
/// Throws std::invalid_argument for arrays of unequal length, std::runtime_error if the file cannot be
/// written.
void writeVtp(const std::filesystem::path& file, const PointCloud& cloud);

/// Writes a .pvd: the files of a series with their times, s. Paths as they shall stand in it, relative to its
/// folder.
void writePvd(const std::filesystem::path& file, const std::vector<std::pair<double, std::string>>& series);

}  // namespace granular
