// SPDX-License-Identifier: MIT
// Reading mesh files, whole and damaged. Files are written here, into a temporary folder.
#include "granular/geometry/mesh_file.h"

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>

#include "granular/geometry/cover.h"
#include "granular/geometry/mesh_distance.h"
#include "granular/geometry/mesh_primitives.h"
#include "mesh_file_fixture.h"

namespace granular {
namespace {

TEST_F(MeshFile, ReadsTheSameBoxFromEveryKindOfFile) {
  for (const auto& [name, content] : everyKindOfFile(box_)) {
    const TriangleMesh mesh = readMeshFile(write(name, content));
    const MeshReport report = checkMesh(mesh);
    EXPECT_TRUE(report.isSolid()) << name << ": " << report.text();
    EXPECT_EQ(mesh.vertices.size(), box_.vertices.size()) << name;  // STL has every corner six times: welded
    EXPECT_EQ(mesh.triangles.size(), box_.triangles.size()) << name;
    EXPECT_NEAR(report.volume, 8.0, 1e-6) << name;
  }
}

TEST_F(MeshFile, CutsPolygonsAndDropsLinesAndPoints) {
  const auto file = write("quads.obj",
                          "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
                          "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\nl 1 7\np 3\n");
  const TriangleMesh mesh = readMeshFile(file);
  EXPECT_EQ(mesh.triangles.size(), 12u);
  EXPECT_TRUE(checkMesh(mesh).isSolid());
}

TEST_F(MeshFile, CutsConcavePolygonsWithoutFillingTheirNotches) {
  // An arrow head in the plane z = 0, area 1: a fan from its first corner would cover the notch.
  const TriangleMesh mesh =
      readMeshFile(write("arrow.obj", "v 0 0 0\nv 1 -1 0\nv 0 1 0\nv -1 -1 0\nf 2 3 4 1\n"));
  EXPECT_EQ(mesh.triangles.size(), 2u);
  EXPECT_NEAR(surfaceArea(mesh), 1.0, 1e-7);
  for (const auto& t : mesh.triangles) EXPECT_GT(doubleAreaVector(mesh, t)[2], 0.0);
}

TEST_F(MeshFile, JoinsThePartsOfAFile) {
  TriangleMesh two = makeBox({1.0, 1.0, 1.0});
  std::string text = "o first\n" + objText(two) + "o second\n";
  for (Vector3& v : two.vertices) v += Vector3(3.0, 0.0, 0.0);
  for (auto& t : two.triangles) {
    for (std::int32_t& v : t) v += 8;
  }
  text += objText(two);
  const MeshReport report = checkMesh(readMeshFile(write("two.obj", text)));
  EXPECT_TRUE(report.isSolid());
  EXPECT_NEAR(report.volume, 2.0, 1e-6);
}

TEST_F(MeshFile, AppliesTheTransformsOfParts) {
  // A tetrahedron of volume 1/6, placed twice: scaled by 2 and mirrored by x -> -x, both moved to x = 5.
  std::string data;
  for (float x : {0.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 0.0f, 1.0f}) put(data, x);
  for (int i : {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3}) put(data, static_cast<std::uint16_t>(i));
  write("tetrahedra.bin", data);
  const auto file = write("tetrahedra.gltf", R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
    "nodes":[{"translation":[5,0,0],"children":[1,2]},{"mesh":0,"scale":[2,2,2]},{"mesh":0,"scale":[-1,1,1]}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],
    "buffers":[{"uri":"tetrahedra.bin","byteLength":72}],
    "bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":24}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,1]},
                 {"bufferView":1,"componentType":5123,"count":12,"type":"SCALAR"}]})");
  const TriangleMesh mesh = readMeshFile(file);
  EXPECT_NEAR(signedVolume(mesh), 8.0 / 6.0 + 1.0 / 6.0, 1e-6);
  EXPECT_NEAR(boundingBox(mesh).lower[0], 4.0, 1e-6);
  EXPECT_NEAR(boundingBox(mesh).upper[0], 7.0, 1e-6);
}

TEST_F(MeshFile, ThatDoesNotExistIsRefused) {
  expectRefused(folder_ / "nothing.obj", "no such file");
}
TEST_F(MeshFile, ThatIsAFolderIsRefused) {
  expectRefused(folder_, "not a regular file");
}
TEST_F(MeshFile, ThatIsEmptyIsRefused) {
  expectRefused(write("empty.ply", ""), "the file is empty");
}
TEST_F(MeshFile, OfAnUnknownKindIsRefused) {
  expectRefused(write("box.txt", "hello"), "unknown kind of file '.txt'");
}
TEST_F(MeshFile, OfPointsOnlyIsRefused) {
  expectRefused(write("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\np 1 2 3\n"), "");
}

TEST_F(MeshFile, LargerThanTheLimitIsRefused) {
  expectRefused(write("box.obj", objText(box_)), "MeshFileLimits.maxBytes", {.maxBytes = 100});
}

TEST_F(MeshFile, WithMoreTrianglesThanTheLimitIsRefused) {
  expectRefused(write("box.obj", objText(box_)), "MeshFileLimits.maxTriangles", {.maxTriangles = 47});
}

TEST_F(MeshFile, WithACoordinateThatIsNotANumberIsRefused) {
  std::string bytes = stlBytes(box_, static_cast<std::uint32_t>(box_.triangles.size()));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::memcpy(bytes.data() + 84 + 12 + 4, &nan, sizeof nan);
  expectRefused(write("nan.stl", bytes), "finite");
}

TEST_F(MeshFile, WithAnIndexOutOfRangeIsRefused) {
  TriangleMesh bad = box_;
  bad.triangles[5][1] = 1000;
  refusal(write("bad.obj", objText(bad)));
  refusal(write("bad.off", offText(bad)));
  refusal(write("bad.ply", plyText(bad, bad.triangles.size())));
}

TEST_F(MeshFile, ThatAnnouncesMoreThanItHoldsIsRefused) {
  expectRefused(write("box.stl", stlBytes(box_, 4'000'000'000u)), "do not fit");
  expectRefused(write("box.ply", plyText(box_, 4'000'000'000u)), "do not fit");
  expectRefused(write("box.off", "OFF\n4000000000 1 0\n0 0 0\n"), "do not fit");
  expectRefused(write("more.off", "OFF 8 4000000000 0\n0 0 0\n"), "do not fit");
}

TEST_F(MeshFile, CutShortAnywhereIsRefusedOrStillAMesh) {
  const std::pair<const char*, std::string> files[] = {
      {"cut.obj", objText(box_)},
      {"cut.off", offText(box_)},
      {"cut.ply", plyText(box_, box_.triangles.size())},
      {"cut.stl", stlBytes(box_, static_cast<std::uint32_t>(box_.triangles.size()))}};
  for (const auto& [name, content] : files) {
    for (std::size_t length = 1; length < content.size(); length += 37) {
      const auto file = write(name, content.substr(0, length));
      try {
        EXPECT_TRUE(checkMesh(readMeshFile(file)).isReadable()) << name << " cut to " << length;
      } catch (const std::runtime_error& error) {
        EXPECT_NE(std::string(error.what()).find(name), std::string::npos);
      }
    }
  }
}

TEST_F(MeshFile, OfOurOwnIsASolid) {
  int meshes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(GRANULAR_MESH_DIR)) {
    const std::filesystem::path& file = entry.path();
    if (file.extension() != ".obj") continue;
    ++meshes;
    const MeshReport report = checkMesh(readMeshFile(file));
    EXPECT_TRUE(report.isSolid()) << file << ": " << report.text();
    EXPECT_EQ(report.degenerateTriangles.count, 0) << file;
    EXPECT_LT(std::filesystem::file_size(file), 300'000u) << file;
  }
  EXPECT_GE(meshes, 16);
}

TEST_F(MeshFile, OfTheRingTakesAboutAsManyParticlesAsThePapers) {
  const TriangleMesh ring = readMeshFile(std::filesystem::path(GRANULAR_MESH_DIR) / "ring.obj");
  const auto count = static_cast<double>(coverMesh(ring, {.particleRadius = 0.115}).positions.size());
  EXPECT_NEAR(count, 110,
              10);  // Bell 2005, sec. 4
}

// Nowhere may two parts of the house be nearer than half a joint: bodies start apart.
TEST_F(MeshFile, OfTheHouseFitTogetherWithoutTouching) {
  std::vector<TriangleMesh> parts;
  for (const char* name : {"front", "back", "gable", "roof", "chimney"}) {
    parts.push_back(
        readMeshFile(std::filesystem::path(GRANULAR_MESH_DIR) / (std::string("house_") + name + ".obj")));
  }
  for (int turned : {2, 3}) {
    parts.push_back(seenFrom({Vector3::Zero(), Quaternion(0.0, 0.0, 0.0, 1.0)}, parts[turned]));
  }
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const MeshDistance distance(parts[i]);
    for (std::size_t j = 0; j < parts.size(); ++j) {
      if (i == j) continue;
      for (const Vector3& v : parts[j].vertices) {
        EXPECT_GT(distance.nearest(v).signedDistance, 0.0024)
            << "part " << i << " and " << j << " at " << v.transpose();
      }
    }
  }
}

TEST_F(MeshFile, OfTheHourglassHoldsItsCavityInside) {
  const MeshDistance distance(readMeshFile(std::filesystem::path(GRANULAR_MESH_DIR) / "hourglass.obj"));
  EXPECT_NEAR(distance.nearest({0.0, 0.0, 0.0}).signedDistance, 0.045,
              0.045 * 0.005);                                         // 36 sides: cos(5 degrees)
  EXPECT_LT(distance.nearest({0.21, 0.0, 0.3}).signedDistance, 0.0);  // in the glass
  EXPECT_GT(distance.nearest({0.0, 0.0, 0.3}).signedDistance, 0.1);   // in the cavity
}

TEST_F(MeshFile, OfACamelCanBeCovered) {
  CoverReport report;
  const TriangleMesh camel = readMeshFile(std::filesystem::path(GRANULAR_MESH_DIR) / "camel.obj");
  coverMesh(camel, {.particleRadius = 0.03}, &report);
  EXPECT_TRUE(report.holesClosed) << report.text();
  EXPECT_LT(report.envelopeMean, 0.4 * 0.03);
}

}  // namespace
}  // namespace granular
