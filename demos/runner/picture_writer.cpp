// SPDX-License-Identifier: MIT
#include "demos/runner/picture_writer.h"

#include <algorithm>

#include "demos/render/film.h"
#include "demos/render/palette.h"

namespace granular_demo {
namespace {

// Surfaces of spheres in every picture, by index.
constexpr std::int32_t kGrainSurface = 0;
constexpr std::int32_t kCoveringSurface = 1;

Color colorOf(const GrainLook& look, std::int32_t grain, double speed) {
  switch (look.coloring) {
    case Coloring::sand:
      return sandColor(static_cast<std::uint64_t>(grain));
    case Coloring::owner:
      return ownerColor(static_cast<std::uint64_t>(grain));
    case Coloring::speed:
      return colorByScalar(speed, 0.0, look.fastest);
    case Coloring::fixed:
      break;
  }
  return look.color;
}

RenderSettings settingsFor(const OutputsDef& outputs, int threads) {
  RenderSettings settings;
  if (outputs.quality == Quality::preview) settings = quickSettings(outputs.width, outputs.height);
  if (outputs.quality == Quality::best) settings = fineSettings(outputs.width, outputs.height);
  settings.width = outputs.width;
  settings.height = outputs.height;
  settings.threads = threads;
  return settings;
}

/// Balls are drawn as the spheres they are, everything else by its triangles.
void addBody(const BuiltBody& body, const std::shared_ptr<const granular::TriangleMesh>& mesh,
             RenderScene& picture) {
  const Surface& surface = body.part->look.surface;
  const Pose pose = body.pose();
  const auto* sphere = std::get_if<SphereShape>(&body.part->shape);
  if (sphere == nullptr) {
    picture.meshes.push_back({mesh, pose, surface});
    return;
  }
  picture.spheres.push_back({pose.position, sphere->radius, Color::Ones(),
                             static_cast<std::int32_t>(picture.sphereSurfaces.size())});
  picture.sphereSurfaces.push_back(surface);
}

/// Frames of an earlier run would come into the film of a shorter one; those before the first one stay, for a
/// run that goes on.
void removeFrames(const std::filesystem::path& folder, int first) {
  for (int i = first; std::filesystem::remove(framePath(folder, i)); ++i) {
  }
}

}  // namespace

PictureSource::PictureSource(const BuiltScene& scene) : scene_(scene) {
  for (const BuiltBody& body : scene.bodies()) {
    const bool isTwin = !meshes_.empty() && scene.bodies()[meshes_.size() - 1].solid == body.solid;
    meshes_.push_back(isTwin ? meshes_.back()
                             : std::make_shared<const granular::TriangleMesh>(joinedMesh(*body.solid)));
  }
}

RenderScene PictureSource::current() const {
  const SceneDef& def = scene_.def();
  RenderScene picture;
  picture.ground = def.look.ground;
  picture.sky = def.look.sky;
  picture.sun = def.look.sun;
  if (def.gravity.norm() > 0.0) picture.up = -def.gravity;
  picture.sphereSurfaces = {Surface{.color = Color::Ones(), .roughness = def.look.ballRoughness},
                            Surface{.color = Color::Ones(), .roughness = 0.8}};
  std::vector<granular::ParticleView> particles;
  scene_.grains().readParticles(particles);
  const auto motions = scene_.grains().grainMotions();
  for (const granular::ParticleView& p : particles) {
    if (p.ownerKind != granular::OwnerKind::Grain) continue;
    const double speed = motions[p.ownerIndex].velocity.norm();
    picture.spheres.push_back(
        {p.position, p.radius, colorOf(scene_.lookOf(p.ownerIndex), p.ownerIndex, speed), kGrainSurface});
  }
  for (std::size_t i = 0; i < meshes_.size(); ++i) {
    const BuiltBody& body = scene_.bodies()[i];
    const BodyLook& look = body.part->look;
    const Pose pose = body.pose();
    if (look.visible) addBody(body, meshes_[i], picture);
    if (!look.showParticles) continue;
    const granular::Covering& covering = body.covering->covering;
    for (std::size_t k = 0; k < covering.positions.size(); ++k) {
      picture.spheres.push_back(
          {pose.toWorld(covering.positions[k]), covering.radii[k], look.particleColor, kCoveringSurface});
    }
  }
  return picture;
}

PictureWriter::PictureWriter(const BuiltScene& scene, const std::filesystem::path& folder, int threads,
                             int firstFrame)
    : scene_(scene),
      source_(scene),
      folder_(folder),
      settings_(settingsFor(scene.def().outputs, threads)),
      cameras_(scene.def().cameras) {
  if (cameras_.empty()) {
    const RenderScene now = source_.current();
    cameras_.push_back(
        {"all", frameBox(boundsOf(now), static_cast<double>(settings_.width) / settings_.height)});
  }
  for (const CameraPart& camera : cameras_) {
    folders_.push_back(folder / (cameras_.size() == 1 ? "frames" : "frames_" + camera.name));
    std::filesystem::create_directories(folders_.back());
    removeFrames(folders_.back(), firstFrame);
  }
}

void PictureWriter::write(int frame) {
  const RenderScene picture = source_.current();
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    writePng(render(picture, cameras_[i].camera, settings_), framePath(folders_[i], frame));
  }
}

std::vector<std::filesystem::path> PictureWriter::writeFilms() const {
  std::vector<std::filesystem::path> films;
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    const std::string name = cameras_.size() == 1 ? "film.mp4" : "film_" + cameras_[i].name + ".mp4";
    writeFilm(
        {.frameFolder = folders_[i], .file = folder_ / name, .framesPerSecond = scene_.def().frameRate});
    films.push_back(folder_ / name);
  }
  return films;
}

}  // namespace granular_demo
