// SPDX-License-Identifier: MIT
// Frames of a running scene as PNG files, one folder a camera, and their films.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "demos/render/render.h"
#include "demos/world/built_scene.h"

namespace granular_demo {

/// The scene as it stands, ready to be drawn.
class PictureSource {
 public:
  explicit PictureSource(const BuiltScene& scene);
  RenderScene current() const;

 private:
  const BuiltScene& scene_;
  std::vector<std::shared_ptr<const granular::TriangleMesh>> meshes_;  // of body i
};

class PictureWriter {
 public:
  /// Makes the folders: frames/ for one camera, frames_<camera>/ for several. Without a camera in the scene,
  /// one that sees everything as it stands now. `scene` must outlive this.
  /// Frames from `firstFrame` on that an earlier run left there are removed.
  PictureWriter(const BuiltScene& scene, const std::filesystem::path& folder, int threads,
                int firstFrame = 0);

  void write(int frame);
  /// Films of the frames written so far: film.mp4 or film_<camera>.mp4. Returns their paths.
  /// Throws std::runtime_error when ffmpeg is missing or fails.
  std::vector<std::filesystem::path> writeFilms() const;

  const std::vector<std::filesystem::path>& frameFolders() const { return folders_; }

 private:
  const BuiltScene& scene_;
  PictureSource source_;
  std::filesystem::path folder_;
  RenderSettings settings_;
  std::vector<CameraPart> cameras_;
  std::vector<std::filesystem::path> folders_;
};

}  // namespace granular_demo
