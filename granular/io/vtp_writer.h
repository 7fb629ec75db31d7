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
  std::vector<Vector3> force;           ///< of all contacts on the particle, N
};

/// A body whose particles go into the file; the system does not keep a list of its bodies for others.
struct CloudBody {
  BodyId id;
  MaterialId material;
};

/// All particles of a system, grains first, in the order of GranularSystem::readParticles. Particles of
/// bodies that are not listed are left out. Forces are those of `contacts` (GranularSystem::readContacts);
/// without contacts there are none.
PointCloud particleCloud(const GranularSystem& system, std::span<const CloudBody> bodies,
                         std::span<const ContactView> contacts = {});

/// Writes the cloud as PolyData with one vertex cell a point; empty arrays are left out.
/// Throws std::invalid_argument for arrays of unequal length, std::runtime_error if the file cannot be
/// written.
void writeVtp(const std::filesystem::path& file, const PointCloud& cloud);

/// Writes the contacts as lines from particle centre to particle centre (to the contact point where a body is
/// met exactly), each with its force (vector on the first owner and size, N), overlap (m) and the kinds and
/// indices of its owners: force chains. Throws std::runtime_error if the file cannot be written.
void writeContactNetwork(const std::filesystem::path& file, std::span<const ParticleView> particles,
                         std::span<const ContactView> contacts);

/// Writes a .pvd: the files of a series with their times, s. Paths as they shall stand in it, relative to its
/// folder.
void writePvd(const std::filesystem::path& file, const std::vector<std::pair<double, std::string>>& series);

}  // namespace granular
