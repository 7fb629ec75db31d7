// SPDX-License-Identifier: MIT
// A folder of frame pictures to a film, by the program ffmpeg.
#pragma once

#include <filesystem>

namespace granular_demo {

struct FilmSettings {
  std::filesystem::path frameFolder = {};  ///< frame_00000.png, frame_00001.png, ..., no gap, all of one size
  std::filesystem::path file = {};         ///< the MP4 to write; one that exists is replaced
  double framesPerSecond = 30.0;           ///< > 0
  int quality = 18;  ///< x264's constant rate factor: 0 lossless, 18 looks lossless, 51 worst
};

/// Path of frame `index` in a folder: frame_%05d.png.
std::filesystem::path framePath(const std::filesystem::path& folder, int index);

/// Writes an MP4 (H.264, yuv420p, playable while it loads) and returns its absolute path.
///
/// Odd picture sizes gain a row or column, since yuv420p needs even ones.
/// @throws std::invalid_argument for settings out of range or a folder without a first frame,
///         std::runtime_error when ffmpeg is not on PATH or fails; the text has ffmpeg's last words
std::filesystem::path writeFilm(const FilmSettings& settings);

}  // namespace granular_demo
