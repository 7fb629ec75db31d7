// SPDX-License-Identifier: MIT
#include <sstream>

#include "granular/geometry/cover.h"

namespace granular {

std::string CoverReport::text() const {
  const double r = particleRadius;
  std::ostringstream out, edges;
  if (edgeLength > 0.0) {
    edges << "\nsharp edges, " << edgeLength << " m: " << edgeParticles
          << " particles along them, envelope mean " << edgeMean / r << " r, max " << edgeMax / r << " r";
  }
  out << particleCount << " particles of radius " << r << " m (D " << density << ", " << filledParticles
      << " added in holes, " << thinParticles << " in thin parts)"
      << "\nspacing / r: min " << spacingMin / r << ", median " << spacingMedian / r << ", max "
      << spacingMax / r << "\nlargest hole: radius " << largestHole / r << " r, "
      << largestHole / smallestGrainRadius << " of the smallest grain's; allowed " << holeBound / r
      << " r: " << (holesClosed ? "holds" : "NOT REACHED") << "\nenvelope from the mesh: mean "
      << envelopeMean / r << " r, max " << envelopeMax / r << " r" << edges.str()
      << "\nfloaters: " << iterations << " iterations, " << fillRounds << " fill rounds, "
      << (converged ? "converged" : "NOT CONVERGED");
  if (!repair.isNothing()) out << "\nmesh repaired: " << repair.text();
  return out.str();
}

}  // namespace granular
