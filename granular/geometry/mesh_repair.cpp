// SPDX-License-Identifier: MIT
#include "granular/geometry/mesh_repair.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <stdexcept>

#include "granular/base/require.h"
#include "granular/geometry/detail/mesh_sides.h"
#include "granular/geometry/winding_number.h"

namespace granular {
namespace {

using detail::forEachEdge;
using detail::sortedSides;
using Side = detail::MeshSide;
using Corners = std::array<std::int32_t, 3>;

[[noreturn]] void refuse(const std::string& why, const MeshReport& report) {
  throw std::invalid_argument("the mesh is not the surface of a solid: " + why + "; it has " + report.text());
}

void dropUseless(TriangleMesh& mesh, MeshRepair& repair) {
  const std::size_t before = mesh.triangles.size();
  std::set<Corners> known;
  std::erase_if(mesh.triangles, [&](const Corners& t) {
    Corners sorted = t;
    std::sort(sorted.begin(), sorted.end());
    return sorted[0] == sorted[1] || sorted[1] == sorted[2] || !known.insert(sorted).second;
  });
  repair.droppedTriangles = static_cast<std::int64_t>(before - mesh.triangles.size());
}

/// Turns triangles until those that share an edge with nobody else agree, the fewer ones of each connected
/// part. Returns the part of each triangle.
class Orienter {
 public:
  explicit Orienter(TriangleMesh& mesh) : mesh_(mesh), next_(mesh.triangles.size()) {
    const std::vector<Side> sides = sortedSides(mesh.triangles);
    forEachEdge(sides, [&](std::size_t first, std::size_t last) {
      if (last - first != 2) return;
      const Side &a = sides[first], &b = sides[first + 1];
      const bool disagree = a.isForward == b.isForward;
      next_[a.triangle].push_back({b.triangle, disagree});
      next_[b.triangle].push_back({a.triangle, disagree});
    });
  }

  std::vector<std::int32_t> run(MeshRepair& repair) {
    std::vector<std::int32_t> part(mesh_.triangles.size(), -1);
    std::vector<char> isTurned(mesh_.triangles.size(), 0);
    std::int32_t parts = 0;
    for (std::size_t seed = 0; seed < part.size(); ++seed) {
      if (part[seed] >= 0) continue;
      const std::vector<std::int32_t> members =
          flood(static_cast<std::int32_t>(seed), parts++, part, isTurned);
      const auto turned =
          std::count_if(members.begin(), members.end(), [&](auto t) { return isTurned[t] != 0; });
      const bool turnOthers = 2 * turned > std::ssize(members);
      for (std::int32_t t : members) {
        if ((isTurned[t] != 0) == turnOthers) continue;
        std::swap(mesh_.triangles[t][1], mesh_.triangles[t][2]);
        ++repair.turnedTriangles;
      }
    }
    return part;
  }

 private:
  struct Neighbour {
    std::int32_t triangle;
    bool disagrees;
  };

  std::vector<std::int32_t> flood(std::int32_t seed, std::int32_t name, std::vector<std::int32_t>& part,
                                  std::vector<char>& isTurned) const {
    std::vector<std::int32_t> members = {seed};
    part[seed] = name;
    for (std::size_t m = 0; m < members.size(); ++m) {
      for (const Neighbour& n : next_[members[m]]) {
        if (part[n.triangle] >= 0) continue;
        part[n.triangle] = name;
        isTurned[n.triangle] = static_cast<char>((isTurned[members[m]] != 0) != n.disagrees);
        members.push_back(n.triangle);
      }
    }
    return members;
  }

  TriangleMesh& mesh_;
  std::vector<std::vector<Neighbour>> next_;
};

/// Fans from the middle of each loop of open edges.
void closeGaps(TriangleMesh& mesh, std::vector<std::int32_t>& part, MeshRepair& repair) {
  struct Way {
    std::int32_t to, part;
  };
  std::multimap<std::int32_t, Way> ways;  // along the open edges, the way a closing triangle must run
  const std::vector<Side> sides = sortedSides(mesh.triangles);
  forEachEdge(sides, [&](std::size_t first, std::size_t last) {
    const Side& s = sides[first];
    if (last - first != 1) return;
    const auto [from, to] = s.isForward ? std::pair(s.high, s.low) : std::pair(s.low, s.high);
    ways.insert({from, {to, part[s.triangle]}});
  });
  while (!ways.empty()) {
    const std::int32_t start = ways.begin()->first, name = ways.begin()->second.part;
    std::vector<std::int32_t> loop;
    for (std::int32_t at = start;;) {
      const auto way = ways.find(at);
      if (way == ways.end()) break;
      loop.push_back(at);
      at = way->second.to;
      ways.erase(way);
      if (at == start) break;
    }
    if (loop.size() < 3) continue;  // what is left of a crossing: nothing to span
    Vector3 middle = Vector3::Zero();
    for (std::int32_t v : loop) middle += mesh.vertices[v] / static_cast<double>(loop.size());
    const auto center = static_cast<std::int32_t>(mesh.vertices.size());
    mesh.vertices.push_back(middle);
    for (std::size_t k = 0; k < loop.size(); ++k) {
      mesh.triangles.push_back({loop[k], loop[(k + 1) % loop.size()], center});
      part.push_back(name);
      repair.closingArea += 0.5 * doubleAreaVector(mesh, mesh.triangles.back()).norm();
    }
    repair.closingTriangles += std::ssize(loop);
    ++repair.closedGaps;
  }
}

/// Turns the parts that look inwards, unless they lie inside another one: those are cavities.
void turnPartsOut(TriangleMesh& mesh, const std::vector<std::int32_t>& part, MeshRepair& repair) {
  const std::int32_t parts = part.empty() ? 0 : *std::max_element(part.begin(), part.end()) + 1;
  std::vector<TriangleMesh> own(parts);
  std::vector<std::int32_t> firstOf(parts, -1);
  for (std::size_t t = 0; t < part.size(); ++t) {
    if (firstOf[part[t]] < 0) firstOf[part[t]] = static_cast<std::int32_t>(t);
    own[part[t]].triangles.push_back(mesh.triangles[t]);
  }
  const Vector3 center = boundingBox(mesh).center();
  std::optional<WindingNumber> all;
  std::vector<char> mustTurn(parts, 0);
  for (std::int32_t p = 0; p < parts; ++p) {
    double sixVolumes = 0.0;
    for (const Corners& t : own[p].triangles) {
      sixVolumes += (mesh.vertices[t[0]] - center).dot(doubleAreaVector(mesh, t));
    }
    if (sixVolumes >= 0.0) continue;
    const Corners& first = mesh.triangles[firstOf[p]];
    const Vector3 probe = (mesh.vertices[first[0]] + mesh.vertices[first[1]] + mesh.vertices[first[2]]) / 3.0;
    if (!all) all.emplace(mesh);
    double ofOthers = all->at(probe);
    for (const Corners& t : own[p].triangles) {
      ofOthers -= windingOfTriangle(mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]], probe);
    }
    mustTurn[p] = std::abs(ofOthers) < 0.5;
    repair.turnedParts += mustTurn[p];
  }
  for (std::size_t t = 0; t < part.size(); ++t) {
    if (mustTurn[part[t]]) std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
  }
}

}  // namespace

TriangleMesh repairMesh(const TriangleMesh& mesh, MeshRepair* repair) {
  const MeshReport report = checkMesh(mesh);
  if (!report.isReadable()) refuse("it cannot be used", report);
  if (!(report.area > 0.0)) refuse("it has no area", report);
  MeshRepair own;
  TriangleMesh solid = mesh;
  const bool isClosed = report.isClosed() && report.duplicateTriangles.count == 0;
  if (!isClosed) {
    weldVertices(solid);
    dropUseless(solid, own);
  }
  // Where a closed mesh has edges of more than two triangles, its parts need not be closed by themselves.
  if (!isClosed || report.crowdedEdges.count == 0 || report.volume < 0.0) {
    std::vector<std::int32_t> part = Orienter(solid).run(own);
    if (!isClosed) closeGaps(solid, part, own);
    if (own.closingArea > kMostClosing * report.area) {
      std::ostringstream why;
      why << "its gaps are " << own.closingArea << " m^2 wide, more than " << kMostClosing
          << " of its area (for a sheet, ask for one with a thickness)";
      refuse(why.str(), report);
    }
    turnPartsOut(solid, part, own);
  }
  const double size = boundingBox(solid).size().norm();
  if (!(signedVolume(solid) > 1e-12 * size * size * size)) refuse("it holds no volume", report);
  own.buriedTriangles = findBuriedTriangles(solid, WindingNumber(solid));
  if (repair) *repair = own;
  return solid;
}

TriangleMesh makeSheet(const TriangleMesh& mesh, double thickness) {
  requirePositive(thickness, "makeSheet thickness", "m");
  const MeshReport report = checkMesh(mesh);
  if (!report.isReadable() || !(report.area > 0.0))
    throw std::invalid_argument("makeSheet cannot use the mesh: " + report.text());
  std::vector<Vector3> normals(mesh.vertices.size(), Vector3::Zero());
  for (const Corners& t : mesh.triangles) {
    for (std::int32_t v : t) normals[v] += doubleAreaVector(mesh, t);
  }
  TriangleMesh sheet;
  for (double side : {0.5, -0.5}) {
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
      const double length = normals[v].norm();
      sheet.vertices.push_back(mesh.vertices[v] +
                               (length > 0.0 ? side * thickness / length : 0.0) * normals[v]);
    }
  }
  const auto back = static_cast<std::int32_t>(mesh.vertices.size());
  for (const Corners& t : mesh.triangles) {
    sheet.triangles.push_back(t);
    sheet.triangles.push_back({t[0] + back, t[2] + back, t[1] + back});
  }
  const std::vector<Side> sides = sortedSides(mesh.triangles);
  forEachEdge(sides, [&](std::size_t first, std::size_t last) {
    if (last - first != 1) return;
    const Side& s = sides[first];
    const std::int32_t from = s.isForward ? s.low : s.high, to = s.isForward ? s.high : s.low;
    sheet.triangles.push_back({to, from, from + back});
    sheet.triangles.push_back({to, from + back, to + back});
  });
  return sheet;
}

std::string MeshRepair::text() const {
  std::ostringstream out;
  const char* separator = "";
  const auto line = [&](std::int64_t count, const std::string& what) {
    if (count == 0) return;
    out << separator << count << ' ' << what;
    separator = "\n";
  };
  line(droppedTriangles, "repeated triangles dropped");
  line(turnedTriangles, "triangles turned to look the way of their neighbours");
  line(turnedParts, "parts were inside out and turned");
  std::ostringstream gaps;
  gaps << "gaps closed with " << closingTriangles << " triangles, " << closingArea << " m^2";
  line(closedGaps, gaps.str());
  line(buriedTriangles.count, "triangles lie inside the solid, first: " + buriedTriangles.firstExample);
  return out.str();
}

}  // namespace granular
