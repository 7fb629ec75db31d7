// SPDX-License-Identifier: MIT
// What .vtp files have in common: arrays appended raw, and the frame round them.
#pragma once

#include <bit>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "granular/base/pose.h"

namespace granular::detail {

/// The two halves of a file: elements that say where each array is, and the arrays, one after the other.
class AppendedData {
 public:
  /// One <DataArray> of `components` numbers a point.
  template <class Number>
  void add(std::string_view name, int components, const std::vector<Number>& numbers) {
    xml_ << "        <DataArray type=\"" << typeName(Number{}) << "\" Name=\"" << name
         << "\" NumberOfComponents=\"" << components << "\" format=\"appended\" offset=\"" << bytes_.size()
         << "\"/>\n";
    const std::uint64_t size = numbers.size() * sizeof(Number);
    append(&size, sizeof size);
    append(numbers.data(), size);
  }

  /// A line between the arrays.
  void line(std::string_view text) { xml_ << text << '\n'; }

  std::string xml() const { return xml_.str(); }
  const std::string& bytes() const { return bytes_; }

 private:
  static const char* typeName(double) { return "Float64"; }
  static const char* typeName(float) { return "Float32"; }
  static const char* typeName(std::int32_t) { return "Int32"; }

  void append(const void* data, std::size_t size) { bytes_.append(static_cast<const char*>(data), size); }

  std::ostringstream xml_;
  std::string bytes_;
};

template <class Number>
std::vector<Number> flattened(const std::vector<Vector3>& vectors) {
  std::vector<Number> numbers;
  numbers.reserve(3 * vectors.size());
  for (const Vector3& v : vectors) {
    for (int i = 0; i < 3; ++i) numbers.push_back(static_cast<Number>(v[i]));
  }
  return numbers;
}

inline void write(const std::filesystem::path& file, const std::string& text) {
  std::ofstream out(file, std::ios::binary);
  out << text;
  out.close();
  if (!out) throw std::runtime_error(file.string() + " cannot be written");
}

inline const char* byteOrder() {
  return std::endian::native == std::endian::little ? "LittleEndian" : "BigEndian";
}

/// One PolyData piece of `points` points, with vertex cells or lines.
inline void writePolyData(const std::filesystem::path& file, std::size_t points, std::size_t vertices,
                          std::size_t lines, const AppendedData& data) {
  std::ostringstream text;
  text << "<?xml version=\"1.0\"?>\n"
       << "<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"" << byteOrder()
       << "\" header_type=\"UInt64\">\n"
       << "  <PolyData>\n"
       << "    <Piece NumberOfPoints=\"" << points << "\" NumberOfVerts=\"" << vertices
       << "\" NumberOfLines=\"" << lines << "\" NumberOfStrips=\"0\" NumberOfPolys=\"0\">\n"
       << data.xml() << "    </Piece>\n"
       << "  </PolyData>\n"
       << "  <AppendedData encoding=\"raw\">\n_" << data.bytes() << "\n  </AppendedData>\n</VTKFile>\n";
  write(file, text.str());
}

}  // namespace granular::detail
