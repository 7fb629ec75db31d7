// SPDX-License-Identifier: MIT
// VTP files, read back by an own small reader: elements by text search, arrays from the appended section.
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "granular/io/vtp_writer.h"

namespace granular {
namespace {

std::filesystem::path scratchFile(const std::string& name) {
  return std::filesystem::path(::testing::TempDir()) / name;
}

std::string textOf(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

/// Value of an attribute in the element that starts at `element`.
std::string attribute(const std::string& text, std::size_t element, const std::string& name) {
  const std::string key = " " + name + "=\"";
  const std::size_t begin = text.find(key, element) + key.size();
  return text.substr(begin, text.find('"', begin) - begin);
}

/// The numbers of the DataArray of that name, as the format defines them: at the offset after the underscore
/// stand a UInt64 byte count and the bytes.
template <class Number>
std::vector<Number> arrayOf(const std::string& text, const std::string& name) {
  const std::size_t named = text.find("Name=\"" + name + "\"");
  if (named == std::string::npos) return {};
  const std::size_t element = text.rfind("<DataArray", named);
  const std::size_t data =
      text.find("_", text.find("<AppendedData")) + 1 + std::stoull(attribute(text, element, "offset"));
  std::uint64_t size = 0;
  std::memcpy(&size, text.data() + data, sizeof size);
  std::vector<Number> numbers(size / sizeof(Number));
  std::memcpy(numbers.data(), text.data() + data + sizeof size, size);
  return numbers;
}

PointCloud threePoints() {
  return {.positions = {{1, 2, 3}, {-4e-9, 5e6, 0.1}, {7, 8, 9}},
          .radius = {0.5, 0.25, 2},
          .velocity = {{1, 0, 0}, {0, -2, 0}, {0, 0, 0.125}},
          .ownerKind = {0, 0, 1},
          .owner = {0, 1, 0},
          .material = {0, 0, 1},
          .force = {{0, 0, 1}, {0, 2, 0}, {3, 0, 0}}};
}

TEST(VtpWriter, PositionsComeBackBitForBit) {
  const auto file = scratchFile("positions.vtp");
  writeVtp(file, threePoints());
  const auto numbers = arrayOf<double>(textOf(file), "Points");
  ASSERT_EQ(numbers.size(), 9u);
  for (int i = 0; i < 9; ++i) EXPECT_EQ(numbers[i], threePoints().positions[i / 3][i % 3]);
}

TEST(VtpWriter, PointDataComesBack) {
  const auto file = scratchFile("data.vtp");
  writeVtp(file, threePoints());
  const std::string text = textOf(file);
  EXPECT_EQ(arrayOf<float>(text, "radius"), (std::vector<float>{0.5f, 0.25f, 2.0f}));
  EXPECT_EQ(arrayOf<float>(text, "velocity"), (std::vector<float>{1, 0, 0, 0, -2, 0, 0, 0, 0.125f}));
  EXPECT_EQ(arrayOf<std::int32_t>(text, "ownerKind"), (std::vector<std::int32_t>{0, 0, 1}));
  EXPECT_EQ(arrayOf<std::int32_t>(text, "owner"), (std::vector<std::int32_t>{0, 1, 0}));
  EXPECT_EQ(arrayOf<std::int32_t>(text, "material"), (std::vector<std::int32_t>{0, 0, 1}));
  EXPECT_EQ(arrayOf<float>(text, "force"), (std::vector<float>{0, 0, 1, 0, 2, 0, 3, 0, 0}));
}

TEST(VtpWriter, EveryPointIsAVertexCell) {
  const auto file = scratchFile("cells.vtp");
  writeVtp(file, threePoints());
  const std::string text = textOf(file);
  const std::size_t piece = text.find("<Piece");
  EXPECT_EQ(attribute(text, piece, "NumberOfPoints"), "3");
  EXPECT_EQ(attribute(text, piece, "NumberOfVerts"), "3");
  EXPECT_EQ(arrayOf<std::int32_t>(text, "connectivity"), (std::vector<std::int32_t>{0, 1, 2}));
  EXPECT_EQ(arrayOf<std::int32_t>(text, "offsets"), (std::vector<std::int32_t>{1, 2, 3}));
}

TEST(VtpWriter, EachTypeNameMatchesTheWidthOfItsNumbers) {
  const auto file = scratchFile("types.vtp");
  writeVtp(file, threePoints());
  const std::string text = textOf(file);
  const auto typeOf = [&](const std::string& name) {
    return attribute(text, text.rfind("<DataArray", text.find("Name=\"" + name + "\"")), "type");
  };
  EXPECT_EQ(typeOf("Points"), "Float64");
  EXPECT_EQ(typeOf("radius"), "Float32");
  EXPECT_EQ(typeOf("owner"), "Int32");
}

TEST(VtpWriter, LeavesEmptyArraysOut) {
  const auto file = scratchFile("bare.vtp");
  writeVtp(file, {.positions = {{1, 2, 3}},
                  .radius = {},
                  .velocity = {},
                  .ownerKind = {},
                  .owner = {},
                  .material = {},
                  .force = {}});
  EXPECT_EQ(textOf(file).find("Name=\"radius\""), std::string::npos);
}

TEST(VtpWriter, RefusesArraysOfUnequalLength) {
  PointCloud cloud = threePoints();
  cloud.radius.pop_back();
  EXPECT_THROW(writeVtp(scratchFile("unequal.vtp"), cloud), std::invalid_argument);
}

TEST(VtpWriter, NamesTheFileItCannotWrite) {
  try {
    writeVtp(scratchFile("no_such_folder") / "a.vtp", threePoints());
    FAIL() << "a folder that is missing went unnoticed";
  } catch (const std::runtime_error& e) {
    EXPECT_NE(std::string(e.what()).find("no_such_folder/a.vtp"), std::string::npos) << e.what();
  }
}

TEST(VtpWriter, SeriesListsFilesWithTheirTimes) {
  const auto file = scratchFile("series.pvd");
  writePvd(file, {{0.0, "p0.vtp"}, {0.5, "p1.vtp"}});
  const std::string text = textOf(file);
  const std::size_t second = text.find("<DataSet", text.find("p0.vtp"));
  EXPECT_EQ(attribute(text, second, "timestep"), "0.5");
  EXPECT_EQ(attribute(text, second, "file"), "p1.vtp");
}

TEST(ParticleCloud, HoldsVelocitiesOfASpinningGrainsParticles) {
  GranularSystem system;
  const MaterialId stone = system.addMaterial({});
  // Two particles 1 m either side of the centre, turning about z at 2 rad/s, moving along x at 3 m/s.
  const GrainShapeId rod = system.addGrainShape({"rod", {{{-1, 0, 0}, 0.1}, {{1, 0, 0}, 0.1}}});
  system.addGrain(
      {.shape = rod, .material = stone, .pose = {}, .velocity = {3, 0, 0}, .angularVelocity = {0, 0, 2}});
  const PointCloud cloud = particleCloud(system, {});
  ASSERT_EQ(cloud.positions.size(), 2u);
  for (int i = 0; i < 2; ++i) {
    const Vector3 expected(3, 2.0 * cloud.positions[i].x(), 0);
    EXPECT_LT((cloud.velocity[i] - expected).norm(), 1e-12);
  }
}

TEST(ParticleCloud, TellsGrainsFromBodies) {
  GranularSystem system;
  const MaterialId stone = system.addMaterial({});
  const MaterialId steel = system.addMaterial({.name = "steel"});
  const GrainShapeId ball = system.addGrainShape(sphereShape(0.1));
  system.addGrain({.shape = ball, .material = stone, .pose = {}});
  const BodyId wall = system.addBody({.covering = {{{5, 0, 0}}, {0.2}}, .material = steel, .pose = {}});
  const CloudBody listed[] = {{wall, steel}};
  const PointCloud cloud = particleCloud(system, listed);
  EXPECT_EQ(cloud.ownerKind, (std::vector<std::int32_t>{0, 1}));
  EXPECT_EQ(cloud.material, (std::vector<std::int32_t>{stone.index, steel.index}));
  EXPECT_EQ(cloud.radius, (std::vector<double>{0.1, 0.2}));
  EXPECT_EQ(particleCloud(system, {}).positions.size(), 1u);
}

/// Two balls that overlap along x, and one apart.
GranularSystem touchingPair() {
  GranularSystem system(SystemDef{.gravity = Vector3::Zero()});
  const MaterialId stone = system.addMaterial({});
  const GrainShapeId ball = system.addGrainShape(sphereShape(0.1));
  for (const double x : {0.0, 0.19, 1.0})
    system.addGrain({.shape = ball, .material = stone, .pose = {.position = {x, 0, 0}}});
  return system;
}

TEST(ParticleCloud, CarriesTheForcesOfItsContacts) {
  GranularSystem system = touchingPair();
  std::vector<ContactView> contacts;
  system.readContacts(contacts);
  ASSERT_EQ(contacts.size(), 1u);
  const PointCloud cloud = particleCloud(system, {}, contacts);
  ASSERT_EQ(cloud.force.size(), 3u);
  EXPECT_LT(cloud.force[0].x(), 0.0);  // pushed apart
  EXPECT_EQ(cloud.force[1], -cloud.force[0]);
  EXPECT_EQ(cloud.force[2], Vector3::Zero());
}

TEST(ContactNetwork, JoinsTheCentresOfTouchingParticles) {
  GranularSystem system = touchingPair();
  std::vector<ContactView> contacts;
  std::vector<ParticleView> particles;
  system.readContacts(contacts);
  system.readParticles(particles);
  const auto file = scratchFile("network.vtp");
  writeContactNetwork(file, particles, contacts);
  const std::string text = textOf(file);
  const std::size_t piece = text.find("<Piece");
  EXPECT_EQ(attribute(text, piece, "NumberOfPoints"), "2");
  EXPECT_EQ(attribute(text, piece, "NumberOfLines"), "1");
  EXPECT_EQ(arrayOf<double>(text, "Points"), (std::vector<double>{0, 0, 0, 0.19, 0, 0}));
  EXPECT_EQ(arrayOf<std::int32_t>(text, "connectivity"), (std::vector<std::int32_t>{0, 1}));
  EXPECT_EQ(arrayOf<std::int32_t>(text, "offsets"), (std::vector<std::int32_t>{2}));
  EXPECT_EQ(arrayOf<std::int32_t>(text, "owners"), (std::vector<std::int32_t>{0, 1}));
  EXPECT_NEAR(arrayOf<float>(text, "overlap").at(0), 0.01, 1e-6);
  const float size = arrayOf<float>(text, "forceSize").at(0);
  EXPECT_NEAR(size, contacts[0].force.norm(), 1e-6 * size);
}

}  // namespace
}  // namespace granular
