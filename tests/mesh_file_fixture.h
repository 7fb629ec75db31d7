// SPDX-License-Identifier: MIT
// Mesh files of every kind, written by hand into a temporary folder.
#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "granular/geometry/mesh_file.h"
#include "granular/geometry/mesh_primitives.h"

namespace granular {

inline std::string objText(const TriangleMesh& mesh) {
  std::ostringstream out;
  for (const Vector3& v : mesh.vertices) out << "v " << v[0] << ' ' << v[1] << ' ' << v[2] << '\n';
  for (const auto& t : mesh.triangles) out << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
  return out.str();
}

inline std::string offText(const TriangleMesh& mesh) {
  std::ostringstream out;
  out << "OFF\n" << mesh.vertices.size() << ' ' << mesh.triangles.size() << " 0\n";
  for (const Vector3& v : mesh.vertices) out << v[0] << ' ' << v[1] << ' ' << v[2] << '\n';
  for (const auto& t : mesh.triangles) out << "3 " << t[0] << ' ' << t[1] << ' ' << t[2] << '\n';
  return out.str();
}

inline std::string plyText(const TriangleMesh& mesh, std::size_t announcedFaces) {
  std::ostringstream out;
  out << "ply\nformat ascii 1.0\nelement vertex " << mesh.vertices.size()
      << "\nproperty float x\nproperty float y\nproperty float z\nelement face " << announcedFaces
      << "\nproperty list uchar int vertex_indices\nend_header\n";
  for (const Vector3& v : mesh.vertices) out << v[0] << ' ' << v[1] << ' ' << v[2] << '\n';
  for (const auto& t : mesh.triangles) out << "3 " << t[0] << ' ' << t[1] << ' ' << t[2] << '\n';
  return out.str();
}

template <class Number>
void put(std::string& out, Number value) {
  char bytes[sizeof value];
  std::memcpy(bytes, &value, sizeof value);
  out.append(bytes, sizeof value);
}

inline std::string stlBytes(const TriangleMesh& mesh, std::uint32_t announced) {
  std::string out(80, ' ');
  put(out, announced);
  for (const auto& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) put(out, 0.0f);
    for (std::int32_t v : t) {
      for (int axis = 0; axis < 3; ++axis) put(out, static_cast<float>(mesh.vertices[v][axis]));
    }
    put(out, std::uint16_t{0});
  }
  return out;
}

class MeshFile : public testing::Test {
 protected:
  MeshFile() {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() / (std::string("granular_mesh_file_") + test->name());
    std::filesystem::create_directories(folder_);
  }
  ~MeshFile() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path write(const std::string& name, const std::string& content) const {
    std::ofstream(folder_ / name, std::ios::binary) << content;
    return folder_ / name;
  }

  /// The message of the refusal, which must be one line with the path in it.
  static std::string refusal(const std::filesystem::path& path, const MeshFileLimits& limits = {}) {
    try {
      readMeshFile(path, limits);
    } catch (const std::runtime_error& error) {
      const std::string text = error.what();
      EXPECT_NE(text.find(path.string()), std::string::npos) << text;
      EXPECT_EQ(text.find('\n'), std::string::npos) << text;
      return text;
    }
    ADD_FAILURE() << path << " was read";
    return {};
  }

  static void expectRefused(const std::filesystem::path& path, const std::string& reason,
                            const MeshFileLimits& limits = {}) {
    EXPECT_NE(refusal(path, limits).find(reason), std::string::npos) << refusal(path, limits);
  }

  const TriangleMesh box_ = makeBox({1.0, 2.0, 4.0}, 2);
  std::filesystem::path folder_;
};

inline std::string plyBytes(const TriangleMesh& mesh) {
  std::string out =
      "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(mesh.vertices.size()) +
      "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
      std::to_string(mesh.triangles.size()) + "\nproperty list uchar int vertex_indices\nend_header\n";
  for (const Vector3& v : mesh.vertices) {
    for (int axis = 0; axis < 3; ++axis) put(out, static_cast<float>(v[axis]));
  }
  for (const auto& t : mesh.triangles) {
    put(out, std::uint8_t{3});
    for (std::int32_t v : t) put(out, v);
  }
  return out;
}

inline std::string stlText(const TriangleMesh& mesh) {
  std::ostringstream out;
  out << "solid box\n";
  for (const auto& t : mesh.triangles) {
    out << "facet normal 0 0 0\nouter loop\n";
    for (std::int32_t v : t) out << "vertex " << mesh.vertices[v].transpose() << '\n';
    out << "endloop\nendfacet\n";
  }
  out << "endsolid box\n";
  return out.str();
}

inline std::string base64(const std::string& bytes) {
  const char* const letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t three = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      three = three << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      out += i + k <= bytes.size() ? letters[three >> (18 - 6 * k) & 63] : '=';
    }
  }
  return out;
}

/// Positions, then indices, as glTF keeps them.
inline std::string gltfBuffer(const TriangleMesh& mesh) {
  std::string out;
  for (const Vector3& v : mesh.vertices) {
    for (int axis = 0; axis < 3; ++axis) put(out, static_cast<float>(v[axis]));
  }
  for (const auto& t : mesh.triangles) {
    for (std::int32_t v : t) put(out, static_cast<std::uint32_t>(v));
  }
  return out;
}

/// @param buffer  what the buffer object holds beside its length
inline std::string gltfJson(const TriangleMesh& mesh, const std::string& buffer) {
  const std::size_t points = 12 * mesh.vertices.size(), faces = 12 * mesh.triangles.size();
  const Box box = boundingBox(mesh);
  std::ostringstream out;
  out << R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
      << R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],)"
      << R"("buffers":[{)" << buffer << R"("byteLength":)" << points + faces << R"(}],)"
      << R"("bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":)" << points
      << R"(,"target":34962},{"buffer":0,"byteOffset":)" << points << R"(,"byteLength":)" << faces
      << R"(,"target":34963}],"accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":)"
      << mesh.vertices.size() << R"(,"min":[)" << box.lower[0] << ',' << box.lower[1] << ',' << box.lower[2]
      << R"(],"max":[)" << box.upper[0] << ',' << box.upper[1] << ',' << box.upper[2]
      << R"(]},{"bufferView":1,"componentType":5125,"type":"SCALAR","count":)" << 3 * mesh.triangles.size()
      << "}]}";
  return out.str();
}

inline std::string gltfText(const TriangleMesh& mesh) {
  return gltfJson(mesh,
                  R"("uri":"data:application/octet-stream;base64,)" + base64(gltfBuffer(mesh)) + R"(",)");
}

inline std::string glbBytes(const TriangleMesh& mesh) {
  std::string json = gltfJson(mesh, "");
  while (json.size() % 4 != 0) json += ' ';
  const std::string buffer = gltfBuffer(mesh);
  std::string out = "glTF";
  put(out, std::uint32_t{2});
  put(out, static_cast<std::uint32_t>(12 + 8 + json.size() + 8 + buffer.size()));
  put(out, static_cast<std::uint32_t>(json.size()));
  out += "JSON" + json;
  put(out, static_cast<std::uint32_t>(buffer.size()));
  out += std::string("BIN\0", 4) + buffer;
  return out;
}

inline std::string daeText(const TriangleMesh& mesh) {
  std::ostringstream out;
  out << R"(<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">)"
      << R"(<asset><up_axis>Y_UP</up_axis></asset><library_geometries><geometry id="g"><mesh>)"
      << R"(<source id="p"><float_array id="pa" count=")" << 3 * mesh.vertices.size() << R"(">)";
  for (const Vector3& v : mesh.vertices) out << v.transpose() << ' ';
  out << R"(</float_array><technique_common><accessor source="#pa" count=")" << mesh.vertices.size()
      << R"(" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>)"
      << R"(<param name="Z" type="float"/></accessor></technique_common></source>)"
      << R"(<vertices id="v"><input semantic="POSITION" source="#p"/></vertices><triangles count=")"
      << mesh.triangles.size() << R"("><input semantic="VERTEX" source="#v" offset="0"/><p>)";
  for (const auto& t : mesh.triangles) out << t[0] << ' ' << t[1] << ' ' << t[2] << ' ';
  out << R"(</p></triangles></mesh></geometry></library_geometries><library_visual_scenes>)"
      << R"(<visual_scene id="s"><node id="n"><instance_geometry url="#g"/></node></visual_scene>)"
      << R"(</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>)";
  return out.str();
}

struct NamedFile {
  std::string name, content;
};

/// The mesh in every kind of file that readMeshFile takes.
inline std::vector<NamedFile> everyKindOfFile(const TriangleMesh& mesh) {
  return {{"box.obj", objText(mesh)},
          {"box.off", offText(mesh)},
          {"text.ply", plyText(mesh, mesh.triangles.size())},
          {"bytes.ply", plyBytes(mesh)},
          {"text.stl", stlText(mesh)},
          {"bytes.STL", stlBytes(mesh, static_cast<std::uint32_t>(mesh.triangles.size()))},
          {"box.gltf", gltfText(mesh)},
          {"box.glb", glbBytes(mesh)},
          {"box.dae", daeText(mesh)}};
}

}  // namespace granular
