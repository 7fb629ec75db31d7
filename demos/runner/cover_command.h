// SPDX-License-Identifier: MIT
// `granular_demo cover FILE`: covers a mesh file with particles and shows what came of it: pictures of mesh,
// iso-surface and particles (figure 6 of Bell 2005), the particles as PLY, a report as text and JSON.
#pragma once

#include <CLI/App.hpp>
#include <filesystem>
#include <optional>

#include "granular/geometry/cover.h"

namespace granular_demo {

/// What the command line asks for.
struct CoverArguments {
  std::filesystem::path file, out;
  std::optional<double> radius;  ///< m; default: about 4000 particles
  std::optional<double> size;    ///< m, of the diagonal of the mesh's box; default: as in the file
  double secondRadius = 0.0;     ///< m, of a second layer that roughens the surface; 0: none
  std::string up;                ///< "y" or "z"; default: y for glTF and COLLADA, z for others
  bool noPictures = false;
  int width = 960, height = 720;
  granular::CoverDef cover = {};  ///< all but the radius
};

void addCoverOptions(CLI::App& command, CoverArguments& arguments);

/// Writes everything to arguments.out. Throws std::runtime_error or std::invalid_argument, one line, if the
/// file cannot be read or covered.
void runCoverCommand(CoverArguments arguments);

}  // namespace granular_demo
