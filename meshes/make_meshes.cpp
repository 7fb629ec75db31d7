// SPDX-License-Identifier: MIT
// Writes the meshes of this folder: granular_make_meshes <folder>. They are closed and of our own making, so
// that tests, demos and users have something to cover whose origin is certain. Lengths in m, z up.
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <string>

#include "granular/geometry/mesh_primitives.h"
#include "meshes/our_meshes.h"

namespace {

using granular::TriangleMesh;
using granular::Vector3;
using namespace granular_meshes;

/// To the tenth of a millimetre that the files keep; corners that coincide then become one.
void roundVertices(TriangleMesh& mesh) {
  for (Vector3& v : mesh.vertices) v = (v * 1e4).array().round() / 1e4;
  granular::weldVertices(mesh);
}

void write(TriangleMesh mesh, const std::filesystem::path& folder, const std::string& name) {
  roundVertices(mesh);
  const granular::MeshReport report = granular::checkMesh(mesh);
  if (!report.isSolid())
    throw std::runtime_error(name + " is not the closed surface of a solid: " + report.text());
  std::ofstream file(folder / (name + ".obj"));
  file << "# " << name << ", written by granular_make_meshes; MIT licence\n";
  file.precision(8);
  for (const Vector3& v : mesh.vertices) file << "v " << v[0] << ' ' << v[1] << ' ' << v[2] << '\n';
  for (const auto& t : mesh.triangles) file << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
  if (!file.flush()) throw std::runtime_error("cannot write " + (folder / (name + ".obj")).string());
  const Vector3 size = granular::boundingBox(mesh).size();
  std::cout << name << ".obj: " << size.transpose() << " m, " << report.text() << '\n';
}

}  // namespace

int main(int argc, char** argv) try {
  const std::filesystem::path folder = argc > 1 ? argv[1] : ".";
  write(granular::makeIcosphere(1.0, 3), folder, "ball");
  write(granular::makeTorus(1.0, 0.25, 48, 20), folder, "ring");
  write(makeCamel(), folder, "camel");
  write(makeStar(), folder, "star");
  write(makeWedge(), folder, "wedge");
  write(makeHourglass(0.045), folder, "hourglass");
  write(makeHourglass(0.09), folder, "hourglass_wide");
  write(makeHourglassFrame(), folder, "hourglass_frame");
  write(makeBlade(), folder, "blade");
  write(makePole(), folder, "pole");
  write(makeTerrain(), folder, "terrain");
  write(makeHouseFront(), folder, "house_front");
  write(makeHouseBack(), folder, "house_back");
  write(makeHouseGable(), folder, "house_gable");
  write(makeHouseRoof(), folder, "house_roof");
  write(makeHouseChimney(), folder, "house_chimney");
  return 0;
} catch (const std::exception& error) {
  std::cerr << "granular_make_meshes: " << error.what() << '\n';
  return 1;
}
