// SPDX-License-Identifier: MIT
// Triangle meshes from files, by way of assimp: OBJ, STL, PLY, OFF, glTF (.gltf, .glb) and COLLADA (.dae).
#pragma once

#include <cstdint>
#include <filesystem>

#include "granular/geometry/triangle_mesh.h"

namespace granular {

/// What is refused, so that a damaged or hostile file cannot eat the machine.
struct MeshFileLimits {
  std::int64_t maxBytes = std::int64_t{1}
                          << 28;          ///< size of the file; reading takes some ten times as much memory
  std::int64_t maxTriangles = 5'000'000;  ///< all parts of the file together
  double maxSeconds = 60.0;               ///< of reading
  std::int64_t maxMemoryBytes = std::int64_t{4} << 30;  ///< of reading, beyond what the program has already
};

/// All triangles of a file as one mesh: node transforms applied, polygons cut into triangles, points and
/// lines dropped, equal vertices welded, triangles without three different corners dropped. Lengths as in the
/// file, taken as m; glTF and COLLADA come with y up. Single precision for most formats: coordinates are good
/// to 1e-7 of their size.
///
/// The importer crashes on some damaged files, or eats memory. So it works in a child process (a fork; on
/// systems without, in the caller): a crash there is an error here, and the limits hold.
///
/// Throws std::runtime_error, one line with the path and what is wrong: no such file, unreadable, empty,
/// unknown kind, a limit exceeded, counts that do not fit the size of the file, not parsable, coordinates not
/// finite, no triangles. Whether the surface is closed is not checked here: see checkMesh.
TriangleMesh readMeshFile(const std::filesystem::path& path, const MeshFileLimits& limits = {});

}  // namespace granular
