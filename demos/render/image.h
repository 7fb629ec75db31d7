// SPDX-License-Identifier: MIT
// A finished picture, 8 bits a channel, and its way to and from a PNG file (libpng).
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace granular_demo {

struct Image {
  int width = 0, height = 0;
  std::vector<std::uint8_t> pixels;  ///< [height * width * 3], rows from the top, red green blue, sRGB

  std::array<std::uint8_t, 3> at(int x, int y) const {
    const std::size_t i = 3 * (static_cast<std::size_t>(y) * width + x);
    return {pixels[i], pixels[i + 1], pixels[i + 2]};
  }
};

/// @throws std::runtime_error with the path when the file cannot be written
void writePng(const Image& image, const std::filesystem::path& path);

/// Any PNG; alpha is dropped. @throws std::runtime_error with the path when it cannot be read
Image readPng(const std::filesystem::path& path);

}  // namespace granular_demo
