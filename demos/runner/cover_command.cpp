// SPDX-License-Identifier: MIT
#include "demos/runner/cover_command.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <thread>

#include "demos/scene/json_object.h"
#include "demos/render/render.h"
#include "granular/geometry/marching_tetrahedra.h"
#include "granular/geometry/mass_properties.h"
#include "granular/geometry/mesh_distance.h"
#include "granular/geometry/mesh_file.h"
#include "granular/geometry/signed_distance_band.h"

namespace granular_demo {
namespace {

using granular::Covering;
using granular::CoverReport;
using granular::TriangleMesh;

constexpr double kUsualParticles = 4000.0;  // as many as the paper's camel

/// A mesh file, read, mended and covered.
struct CoveredFile {
  granular::MeshReport asRead;
  TriangleMesh mesh;
  TriangleMesh isoSurface;  // at the offset, on the voxels that the covering uses
  Covering covering;
  CoverReport report;
  std::optional<CoverReport> secondReport;
  granular::MassProperties unitMass;  // at density 1
  double seconds = 0.0;               // to read and cover it
};

double usualRadius(double area) {
  constexpr double kDensity = 0.84;  // CoverDef::density for grains of the same radius
  return std::sqrt(kDensity * area / (std::numbers::pi * kUsualParticles));
}

void resize(TriangleMesh& mesh, double diagonal) {
  const double scale = diagonal / granular::boundingBox(mesh).size().norm();
  if (!std::isfinite(scale)) throw std::runtime_error("--size: the mesh has no size of its own");
  for (Vector3& v : mesh.vertices) v *= scale;
}

TriangleMesh isoSurfaceOf(const CoveredFile& file, const granular::CoverDef& def) {
  const double r = def.particleRadius, offset = def.offset.value_or(-r);
  const bool hasBuriedParts = file.report.repair.buriedTriangles.count > 0;
  const granular::MeshDistance distance(
      file.mesh, hasBuriedParts ? granular::MeshSign::WindingNumber : granular::MeshSign::PseudoNormal);
  const granular::SignedDistanceBand band(
      distance, {.spacing = r, .lower = offset, .upper = offset, .threads = def.threads});
  return granular::marchingTetrahedra(band, offset);
}

CoveredFile coverFile(CoverArguments& a) {
  CoveredFile file;
  const auto start = std::chrono::steady_clock::now();
  TriangleMesh read = granular::readMeshFile(a.file);
  if (a.size) resize(read, *a.size);
  file.asRead = granular::checkMesh(read);
  if (a.cover.sheetThickness) read = granular::makeSheet(read, *a.cover.sheetThickness);
  a.cover.sheetThickness.reset();
  granular::MeshRepair repair;
  file.mesh = granular::repairMesh(read, &repair);
  a.cover.particleRadius = a.radius.value_or(usualRadius(granular::surfaceArea(file.mesh)));
  file.covering = granular::coverMesh(file.mesh, a.cover, &file.report);
  if (a.secondRadius > 0.0) {
    granular::CoverDef second = a.cover;
    second.particleRadius = a.secondRadius;
    second.offset = 0.0;
    second.edgeParticleRadius.reset();
    second.seed = a.cover.seed + 1;
    file.secondReport.emplace();
    granular::append(file.covering, granular::coverMesh(file.mesh, second, &*file.secondReport));
  }
  file.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  file.report.repair = repair;
  file.unitMass = granular::massProperties(file.mesh, 1.0);
  return file;
}

std::string textOf(const CoverArguments& a, const CoveredFile& file) {
  std::ostringstream out;
  out << a.file.filename().string() << ": " << file.asRead.text() << '\n';
  const granular::MassProperties& m = file.unitMass;
  out << "as a solid: volume " << m.volume << " m^3, centre of mass " << m.centerOfMass.transpose()
      << " m, principal moments at density 1 " << m.principalMoments.transpose() << " m^5\n";
  out << file.report.text() << '\n';
  if (file.secondReport) out << "second layer: " << file.secondReport->text() << '\n';
  return out.str();
}

Json jsonOf(const granular::MeshFault& fault) {
  return {{"count", fault.count}, {"first", fault.firstExample}};
}

Json jsonOf(const Vector3& v) {
  return {v[0], v[1], v[2]};
}

Json jsonOf(const CoverReport& r) {
  return {{"particles", r.particleCount},
          {"particleRadius", r.particleRadius},
          {"density", r.density},
          {"spacing", {{"min", r.spacingMin}, {"median", r.spacingMedian}, {"max", r.spacingMax}}},
          {"smallestGrainRadius", r.smallestGrainRadius},
          {"largestHole", r.largestHole},
          {"holeBound", r.holeBound},
          {"holesClosed", r.holesClosed},
          {"envelope", {{"mean", r.envelopeMean}, {"max", r.envelopeMax}}},
          {"sharpEdges",
           {{"length", r.edgeLength},
            {"particles", r.edgeParticles},
            {"envelopeMean", r.edgeMean},
            {"envelopeMax", r.edgeMax}}},
          {"thinParticles", r.thinParticles},
          {"filledParticles", r.filledParticles},
          {"iterations", r.iterations},
          {"converged", r.converged}};
}

Json jsonOf(const CoverArguments& a, const CoveredFile& file) {
  const granular::MeshReport& m = file.asRead;
  const granular::MeshRepair& repair = file.report.repair;
  Json report;
  report["file"] = a.file.string();
  report["mesh"] = {{"triangles", m.triangleCount},
                    {"vertices", m.vertexCount},
                    {"area", m.area},
                    {"volume", m.volume},
                    {"closed", m.isClosed()},
                    {"openEdges", jsonOf(m.openEdges)},
                    {"flippedEdges", jsonOf(m.flippedEdges)},
                    {"crowdedEdges", jsonOf(m.crowdedEdges)},
                    {"duplicateTriangles", jsonOf(m.duplicateTriangles)},
                    {"degenerateTriangles", jsonOf(m.degenerateTriangles)},
                    {"slivers", jsonOf(m.slivers)}};
  report["repair"] = {{"droppedTriangles", repair.droppedTriangles},
                      {"turnedTriangles", repair.turnedTriangles},
                      {"turnedParts", repair.turnedParts},
                      {"closedGaps", repair.closedGaps},
                      {"closingTriangles", repair.closingTriangles},
                      {"closingArea", repair.closingArea},
                      {"buriedTriangles", jsonOf(repair.buriedTriangles)}};
  report["solid"] = {{"volume", file.unitMass.volume},
                     {"centerOfMass", jsonOf(file.unitMass.centerOfMass)},
                     {"principalMomentsAtDensityOne", jsonOf(file.unitMass.principalMoments)}};
  report["covering"] = jsonOf(file.report);
  if (file.secondReport) report["secondLayer"] = jsonOf(*file.secondReport);
  report["seconds"] = file.seconds;
  return report;
}

void writeText(const std::filesystem::path& path, const std::string& text) {
  std::ofstream out(path);
  out << text;
  if (!out.flush()) throw std::runtime_error("cannot write " + path.string());
  std::cout << "wrote " << path.string() << '\n';
}

void writePly(const Covering& covering, const std::filesystem::path& path) {
  std::ostringstream out;
  out << "ply\nformat ascii 1.0\ncomment particles: centre and radius, m\nelement vertex "
      << covering.positions.size()
      << "\nproperty double x\nproperty double y\nproperty double z\nproperty double radius\nend_header\n"
      << std::setprecision(12);
  for (std::size_t i = 0; i < covering.positions.size(); ++i) {
    out << covering.positions[i].transpose() << ' ' << covering.radii[i] << '\n';
  }
  writeText(path, out.str());
}

bool isYUp(const CoverArguments& a) {
  if (!a.up.empty()) return a.up == "y";
  const std::string extension = a.file.extension().string();
  return extension == ".gltf" || extension == ".glb" || extension == ".dae";
}

Image besideOneAnother(const std::vector<Image>& images) {
  Image all{.width = 0, .height = images.front().height, .pixels = {}};
  for (const Image& image : images) all.width += image.width;
  for (int y = 0; y < all.height; ++y) {
    for (const Image& image : images) {
      const auto row = image.pixels.begin() + static_cast<std::ptrdiff_t>(3) * y * image.width;
      all.pixels.insert(all.pixels.end(), row, row + static_cast<std::ptrdiff_t>(3) * image.width);
    }
  }
  return all;
}

void writePictures(const CoverArguments& a, const CoveredFile& file) {
  const bool yUp = isYUp(a);
  const granular::Box box = granular::boundingBox(file.mesh);
  RenderScene stage;
  stage.up = yUp ? Vector3::UnitY() : Vector3::UnitZ();
  stage.ground->height = yUp ? box.lower.y() : box.lower.z();
  stage.sun.towards = yUp ? Vector3(-0.5, 0.75, 0.6) : Vector3(-0.5, -0.6, 0.75);
  const Camera camera =
      frameBox(box, static_cast<double>(a.width) / a.height,
               yUp ? Vector3(-0.45, -0.35, -1.0) : Vector3(-0.45, 1.0, -0.35), stage.up, 30.0, 1.12);
  RenderSettings settings{.width = a.width, .height = a.height, .threads = a.cover.threads};
  const auto withMesh = [&](const TriangleMesh& mesh, const Color& color) {
    RenderScene scene = stage;
    scene.meshes.push_back(
        {std::make_shared<TriangleMesh>(mesh), {}, Surface{.color = color, .roughness = 0.55}});
    return scene;
  };
  RenderScene particles = stage;
  for (std::size_t i = 0; i < file.covering.positions.size(); ++i) {
    const bool isMain = file.covering.radii[i] == file.report.particleRadius;
    particles.spheres.push_back({file.covering.positions[i], file.covering.radii[i],
                                 isMain ? Color(0.80f, 0.66f, 0.42f) : Color(0.35f, 0.52f, 0.70f), 0});
  }
  std::vector<Image> images;
  const auto draw = [&](const RenderScene& scene, const char* name) {
    images.push_back(render(scene, camera, settings));
    writePng(images.back(), a.out / name);
    std::cout << "wrote " << (a.out / name).string() << '\n';
  };
  draw(withMesh(file.mesh, Color(0.72f, 0.70f, 0.66f)), "mesh.png");
  draw(withMesh(isoSurfaceOf(file, a.cover), Color(0.52f, 0.62f, 0.72f)), "iso_surface.png");
  draw(particles, "particles.png");
  writePng(besideOneAnother(images), a.out / "figure.png");
  std::cout << "wrote " << (a.out / "figure.png").string() << '\n';
}

}  // namespace

void addCoverOptions(CLI::App& command, CoverArguments& a) {
  command.add_option("file", a.file, "Mesh: .obj, .stl, .ply, .off, .gltf, .glb or .dae")->required();
  command.add_option("--out", a.out, "Folder for all files")->required();
  command.add_option("--radius", a.radius, "Of the particles, m; default: about 4000 of them");
  command.add_option("--offset", a.cover.offset,
                     "Of their centres, m, outwards; default: one radius inwards");
  command.add_option("--density", a.cover.density,
                     "D of the paper, discs over area; default: just enough that no grain can pass");
  command.add_option("--grain", a.cover.smallestGrainRadius, "Smallest grain that must not pass, m");
  command.add_option("--hole", a.cover.largestHole, "Largest hole allowed, m; default: half that grain");
  command.add_option("--edge-radius", a.cover.edgeParticleRadius,
                     "Of smaller particles along sharp edges, m");
  command.add_option("--sharp", a.cover.sharpEdgeDegrees, "Edges that turn by more are kept; 180: none")
      ->capture_default_str();
  command.add_option("--sheet", a.cover.sheetThickness, "Cover the mesh as a sheet this thick, m");
  command.add_option("--second-layer", a.secondRadius, "Radius of a second layer on the surface, m");
  command.add_option("--size", a.size, "Diagonal of the mesh's box, m; default: as in the file");
  command.add_option("--seed", a.cover.seed, "Of the random start")->capture_default_str();
  command.add_option("--up", a.up, "Axis that points up in pictures")->check(CLI::IsMember({"y", "z"}));
  command.add_option("--width", a.width, "Of each picture")->check(CLI::Range(16, 8192));
  command.add_option("--height", a.height, "Of each picture")->check(CLI::Range(16, 8192));
  a.cover.threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  command.add_option("--threads", a.cover.threads, "The result is the same for any number")
      ->check(CLI::Range(1, 1024));
  command.add_flag("--no-pictures", a.noPictures, "Particles and report alone");
}

void runCoverCommand(CoverArguments a) {
  const CoveredFile file = coverFile(a);
  std::filesystem::create_directories(a.out);
  const std::string text = textOf(a, file);
  std::cout << text;
  writeText(a.out / "report.txt", text);
  writeText(a.out / "report.json",
            jsonOf(a, file).dump(2, ' ', false, Json::error_handler_t::replace) + '\n');
  writePly(file.covering, a.out / "particles.ply");
  if (!a.noPictures) writePictures(a, file);
}

}  // namespace granular_demo
