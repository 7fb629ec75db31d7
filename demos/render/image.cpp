// SPDX-License-Identifier: MIT
// Through libpng's simplified interface (libpng manual, section VI), which needs no setjmp.
#include "demos/render/image.h"

#include <png.h>

#include <stdexcept>
#include <string>

#include "granular/base/require.h"

namespace granular_demo {
namespace {

png_image headerOf(int width, int height) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(width);
  header.height = static_cast<png_uint_32>(height);
  header.format = PNG_FORMAT_RGB;
  return header;
}

[[noreturn]] void fail(const char* what, const std::filesystem::path& path, const png_image& header) {
  throw std::runtime_error(std::string("Cannot ") + what + " picture '" + path.string() +
                           "': " + header.message);
}

}  // namespace

void writePng(const Image& image, const std::filesystem::path& path) {
  const std::size_t expected = std::size_t{3} * static_cast<std::size_t>(image.width) * image.height;
  granular::require(image.width > 0 && image.height > 0 && image.pixels.size() == expected,
                    "Image.pixels.size()", image.pixels.size(), "", "3 * width * height and > 0");
  png_image header = headerOf(image.width, image.height);
  if (!png_image_write_to_file(&header, path.c_str(), 0, image.pixels.data(), 0, nullptr))
    fail("write", path, header);
}

Image readPng(const std::filesystem::path& path) {
  png_image header = headerOf(0, 0);
  if (!png_image_begin_read_from_file(&header, path.c_str())) fail("read", path, header);
  header.format = PNG_FORMAT_RGB;
  Image image{static_cast<int>(header.width), static_cast<int>(header.height), {}};
  image.pixels.resize(PNG_IMAGE_SIZE(header));
  const png_color black{0, 0, 0};
  if (!png_image_finish_read(&header, &black, image.pixels.data(), 0, nullptr)) fail("read", path, header);
  return image;
}

}  // namespace granular_demo
