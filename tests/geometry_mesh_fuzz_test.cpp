// SPDX-License-Identifier: MIT
// Damaged mesh files, made from good ones of every kind: whatever comes, an error in one line or a mesh that
// can be used, in time, and the program lives on. The importer itself crashes on some of these.
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <stdexcept>
#include <thread>

#include "granular/base/random.h"
#include "granular/geometry/cover.h"
#include "granular/geometry/detail/child_process.h"
#include "mesh_file_fixture.h"

namespace granular {
namespace {

class DamagedMeshFile : public MeshFile {
 protected:
  /// Reads a file that may be damaged; counts what came of it.
  void tryToRead(const std::string& name, const std::string& content) {
    const auto file = write(name, content);
    try {
      const TriangleMesh mesh =
          readMeshFile(file, {.maxSeconds = 20.0, .maxMemoryBytes = std::int64_t{1} << 30});
      EXPECT_TRUE(checkMesh(mesh).isReadable()) << name;
      ++meshes_;
    } catch (const std::runtime_error& error) {
      EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
      ++refusals_;
    }
  }

  int meshes_ = 0, refusals_ = 0;
};

TEST_F(DamagedMeshFile, CutShortAnywhereIsRefusedOrAMesh) {
  for (const auto& [name, content] : everyKindOfFile(makeBox({1.0, 2.0, 4.0}))) {
    for (int part = 0; part < 12; ++part) {
      tryToRead(name, content.substr(0, 1 + content.size() * static_cast<std::size_t>(part) / 12));
    }
    tryToRead(name, content.substr(0, content.size() - 1));
  }
  EXPECT_GT(refusals_, 60);
}

TEST_F(DamagedMeshFile, WithBytesChangedIsRefusedOrAMesh) {
  Random random(5);
  for (const auto& [name, content] : everyKindOfFile(makeBox({1.0, 2.0, 4.0}))) {
    for (int n = 0; n < 24; ++n) {
      std::string damaged = content;
      for (int change = 0; change < 1 + n % 4; ++change) {
        const auto at = static_cast<std::size_t>(random.bits() % damaged.size());
        damaged[at] = static_cast<char>(random.bits());
      }
      tryToRead(name, damaged);
    }
  }
  EXPECT_GT(refusals_ + meshes_, 200);
}

TEST_F(DamagedMeshFile, WithHugeNumbersIsRefusedOrAMesh) {
  for (const auto& [name, content] : everyKindOfFile(makeBox({1.0, 2.0, 4.0}))) {
    for (const char* huge : {"4294967295", "-1", "99999999999999999999", "1e39", "nan"}) {
      // In place of the first, a middle and the last number.
      for (double part : {0.0, 0.3, 0.6, 0.95}) {
        const auto at = content.find_first_of(
            "0123456789", static_cast<std::size_t>(part * static_cast<double>(content.size())));
        if (at == std::string::npos) continue;
        const auto end = content.find_first_not_of("0123456789.", at);
        tryToRead(name, content.substr(0, at) + huge + (end == std::string::npos ? "" : content.substr(end)));
      }
    }
  }
  EXPECT_GT(refusals_ + meshes_, 100);
}

TEST_F(DamagedMeshFile, OfAnotherKindThanItsNameIsRefusedOrAMesh) {
  const std::vector<NamedFile> files = everyKindOfFile(makeBox({1.0, 2.0, 4.0}));
  for (const NamedFile& content : files) {
    for (const NamedFile& name : files) tryToRead("as_" + content.name + "_" + name.name, content.content);
  }
  EXPECT_GE(meshes_, 9);
}

TEST_F(DamagedMeshFile, ThatMayNotBeReadIsRefused) {
  const auto file = write("secret.obj", objText(box_));
  std::filesystem::permissions(file, std::filesystem::perms::none);
  // In a child, which can become nobody: root may read everything.
  const std::string refusal = detail::runInChild({}, [&]() -> std::string {
    if (geteuid() == 0 && setuid(65534) != 0) return "cannot become nobody";
    try {
      readMeshFile(file);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "it was read";
  });
  EXPECT_NE(refusal.find("cannot be read"), std::string::npos) << refusal;
}

TEST_F(DamagedMeshFile, OfTenMetresOrTenMicrometresIsCovered) {
  for (double size : {10.0, 1e-5}) {
    const TriangleMesh mesh = readMeshFile(write("box.ply", plyBytes(makeBox(Vector3::Constant(size)))));
    CoverReport report;
    coverMesh(mesh, {.particleRadius = 0.05 * size}, &report);
    EXPECT_TRUE(report.holesClosed) << size << ": " << report.text();
    EXPECT_NEAR(report.repair.closingArea, 0.0, 0.0);
  }
}

TEST(ChildProcess, BringsBackWhatTheWorkMakes) {
  std::string large(3'000'000, 'x');
  large[1234567] = 0;
  EXPECT_EQ(detail::runInChild({}, [&] { return large; }), large);
}

TEST(ChildProcess, TurnsACrashIntoAnError) {
  const auto crash = []() -> std::string { std::abort(); };
  try {
    detail::runInChild({}, crash);
    FAIL() << "a crash went by";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("crashes"), std::string::npos) << error.what();
  }
}

TEST(ChildProcess, EndsWorkThatTakesTooLong) {
  const auto start = std::chrono::steady_clock::now();
  const auto hang = []() -> std::string {
    while (true) std::this_thread::sleep_for(std::chrono::seconds(1));
  };
  EXPECT_THROW(detail::runInChild({.seconds = 0.2}, hang), std::runtime_error);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10));
}

// Sanitizers reserve terabytes of addresses for themselves: under them a process cannot be limited.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST(ChildProcess, EndsWorkThatTakesTooMuchMemory) {
  const auto eat = [] { return std::string(std::size_t{1} << 30, 'x'); };
  try {
    detail::runInChild({.memoryBytes = std::int64_t{1} << 27}, eat);
    FAIL() << "a gigabyte went by";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("128 MiB"), std::string::npos) << error.what();
  }
}
#endif

TEST(ChildProcess, PassesOnWhatTheWorkThrows) {
  const auto refuse = []() -> std::string { throw std::invalid_argument("no such thing"); };
  try {
    detail::runInChild({}, refuse);
    FAIL() << "an error went by";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "no such thing");
  }
}

}  // namespace
}  // namespace granular
