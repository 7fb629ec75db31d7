// SPDX-License-Identifier: MIT
// Pictures, films and figures: geometry against projection by hand, files against what went in.
#include "demos/render/render.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <numbers>
#include <set>
#include <sstream>
#include <string>

#include "demos/render/film.h"
#include "demos/render/mesh_normals.h"
#include "demos/render/palette.h"
#include "demos/render/path_tracer.h"
#include "demos/render/plot.h"
#include "demos/render/ray_scene.h"
#include "demos/render/sampling.h"
#include "demos/render/tone.h"
#include "granular/base/random.h"
#include "granular/geometry/mesh_primitives.h"

// fontconfig keeps a few patterns until the end of the process; they are not ours to free.
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libfontconfig";
}

namespace granular_demo {
namespace {

namespace fs = std::filesystem;
using granular::Quaternion;
using granular::Random;
using granular::TriangleMesh;

constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// A folder of its own for each test, gone afterwards.
class FileTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "render_test_XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path folder_;
};

class ImageFile : public FileTest {};
class FilmFile : public FileTest {};
class FigureFile : public FileTest {};

/// Sets an environment variable until the end of the block.
class ScopedVariable {
 public:
  ScopedVariable(const char* name, const std::string& value) : name_(name), before_(std::getenv(name)) {
    setenv(name, value.c_str(), 1);
  }
  ~ScopedVariable() { setenv(name_, before_.c_str(), 1); }

 private:
  const char* name_;
  std::string before_;
};

/// What an action throws, as text; empty when it does not throw.
template <class Exception, class Action>
std::string messageOf(const Action& action) {
  try {
    action();
  } catch (const Exception& e) {
    return e.what();
  }
  return "";
}

std::shared_ptr<const TriangleMesh> shared(TriangleMesh mesh) {
  return std::make_shared<const TriangleMesh>(std::move(mesh));
}

Sky evenSky(const Color& color) {
  return {.zenith = color, .horizon = color};
}

int brightness(const Image& image, int x, int y) {
  const auto pixel = image.at(x, y);
  return (pixel[0] + pixel[1] + pixel[2]) / 3;
}

/// Some of everything that can be drawn.
RenderScene mixedScene() {
  RenderScene scene;
  Random random(11);
  for (int i = 0; i < 300; ++i)
    scene.spheres.push_back({Vector3(random.uniform(-1, 1), random.uniform(0.05, 0.4), random.uniform(-1, 1)),
                             0.06, sandColor(static_cast<std::uint64_t>(i)), 0});
  scene.sphereSurfaces.push_back({.roughness = 0.1, .metallic = 1.0});
  scene.sphereSurfaces.push_back({.color = Color(0.7f, 0.9f, 0.8f), .opacity = 0.2, .glass = Glass::solid});
  scene.spheres.push_back({Vector3(0.3, 0.6, 0.3), 0.25, Color::Ones(), 1});
  scene.spheres.push_back({Vector3(-0.5, 0.6, 0.3), 0.2, Color::Ones(), 2});
  // Two at one place: which of them a ray meets must not depend on luck.
  scene.spheres.push_back({Vector3(0.8, 0.5, 0.5), 0.15, Color(0.9f, 0.1f, 0.1f), 0});
  scene.spheres.push_back({Vector3(0.8, 0.5, 0.5), 0.15, Color(0.1f, 0.1f, 0.9f), 0});
  const auto box = shared(granular::makeBox(Vector3(1.5, 0.8, 0.03)));
  scene.meshes.push_back({box, {Vector3(0, 0.4, -0.9)}, {.opacity = 0.1, .glass = Glass::solid}});
  scene.meshes.push_back(
      {box, {Vector3(0, 0.4, -1.3)}, {.color = Color(0.2f, 0.3f, 0.5f), .roughness = 0.2}});
  return scene;
}

TEST(Camera, ShowsTheTargetInTheMiddleOfThePicture) {
  const Camera camera{.eye = {1, 2, 3}, .target = {-2, 0.5, -1}};
  const Eigen::Vector2d pixel = projectToPixel(camera, 640, 360, camera.target);
  EXPECT_NEAR(pixel.x(), 320.0, 1e-9);
  EXPECT_NEAR(pixel.y(), 180.0, 1e-9);
}

TEST(Camera, ShowsHalfTheFieldOfViewAtTheUpperEdge) {
  const Camera camera{.eye = {0, 0, 2}, .target = {0, 0, 0}, .verticalFieldOfViewDegrees = 50};
  const double top = 2.0 * std::tan(25.0 * std::numbers::pi / 180.0);
  EXPECT_NEAR(projectToPixel(camera, 640, 360, {0, top, 0}).y(), 0.0, 1e-9);
  EXPECT_NEAR(projectToPixel(camera, 640, 360, {top, 0, 0}).x(), 320.0 + 180.0, 1e-9);  // pixels are square
}

TEST(Camera, FramesABoxWithEveryCornerInThePictureAndOneAtItsMargin) {
  constexpr int kWidth = 800, kHeight = 450;
  constexpr double kMargin = 1.1;
  const Box box{{-0.4, 0.0, -0.1}, {0.7, 0.3, 0.5}};
  const Vector3 direction(-0.3, -0.5, -0.8);
  const Camera camera = frameBox(box, double{kWidth} / kHeight, direction, Vector3::UnitY(), 35.0, kMargin);
  double farthestOut = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vector3 p((corner & 1 ? box.upper : box.lower).x(), (corner & 2 ? box.upper : box.lower).y(),
                    (corner & 4 ? box.upper : box.lower).z());
    const Eigen::Vector2d pixel = projectToPixel(camera, kWidth, kHeight, p);
    farthestOut =
        std::max({farthestOut, std::abs(2 * pixel.x() / kWidth - 1), std::abs(2 * pixel.y() / kHeight - 1)});
  }
  EXPECT_NEAR(farthestOut, 1.0 / kMargin, 1e-9);
}

TEST(Camera, RefusesAnUpDirectionAlongTheView) {
  const Camera camera{.eye = {0, 2, 0}, .target = {0, 0, 0}, .up = {0, 1, 0}};
  const std::string message =
      messageOf<std::invalid_argument>([&] { render(RenderScene{}, camera, {.width = 8, .height = 8}); });
  EXPECT_NE(message.find("Camera.up"), std::string::npos) << message;
}

// A dark sphere off the axis before a bright sky. A pixel is inside (outside) if the line of sight through
// each corner of a square two pixels wide around its centre meets (misses) the sphere: the filter reaches 0.8
// pixels.
TEST(Render, SphereCoversThePixelsTheProjectionSays) {
  constexpr int kWidth = 160, kHeight = 120;
  const Camera camera{.eye = {0, 0, 5}, .target = {0, 0, 0}, .verticalFieldOfViewDegrees = 40};
  const Vector3 center(0.9, 0.6, -0.5);
  constexpr double kRadius = 0.8;
  RenderScene scene{
      .spheres = {{center, kRadius, Color::Zero(), 0}}, .ground = {}, .sky = evenSky(Color::Ones())};
  scene.sun.irradiance = 0.0;
  const Image image = render(scene, camera, {.width = kWidth, .height = kHeight, .samplesPerPixel = 16});

  const double halfHeight = std::tan(20.0 * std::numbers::pi / 180.0);
  const auto meets = [&](double x, double y) {
    const Vector3 sight((2 * x / kWidth - 1) * halfHeight * kWidth / kHeight,
                        (1 - 2 * y / kHeight) * halfHeight, -1);
    return (center - camera.eye).cross(sight.normalized()).norm() < kRadius;
  };
  int inside = 0, outside = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      int corners = 0;
      for (const double dx : {-0.5, 1.5})
        for (const double dy : {-0.5, 1.5}) corners += meets(x + dx, y + dy);
      if (corners == 4) {
        EXPECT_LT(brightness(image, x, y), 140) << x << ' ' << y;
      }
      if (corners == 0) {
        EXPECT_GT(brightness(image, x, y), 200) << x << ' ' << y;
      }
      inside += corners == 4;
      outside += corners == 0;
    }
  }
  EXPECT_GT(inside, 1000);
  EXPECT_GT(outside, 10000);
}

// Black sky, sun without a disc: a point of the ground is dark exactly if its line to the sun meets the
// sphere.
TEST(Render, ShadowFallsWhereTheSunIsHidden) {
  constexpr int kWidth = 200, kHeight = 150;
  const Camera camera{.eye = {0, 9, 4}, .target = {0, 0, 0}, .verticalFieldOfViewDegrees = 40};
  const Vector3 center(-0.4, 1.5, 0.3), towardsSun = Vector3(-0.6, 0.7, 0.35).normalized();
  constexpr double kRadius = 0.7;
  RenderScene scene{.spheres = {{center, kRadius, Color::Zero(), 0}}, .sky = evenSky(Color::Zero())};
  scene.sun = {.towards = towardsSun, .angularRadiusDegrees = 0.0};
  const Image image = render(scene, camera, {.width = kWidth, .height = kHeight});

  int dark = 0, lit = 0;
  for (double x = -2.5; x < 2.5; x += 0.07) {
    for (double z = -2.0; z < 2.0; z += 0.07) {
      const Vector3 point(x, 0, z);
      const Vector3 sight = (point - camera.eye).normalized();
      if ((center - camera.eye).cross(sight).norm() < 1.2 * kRadius) continue;  // behind the sphere
      const Eigen::Vector2d pixel = projectToPixel(camera, kWidth, kHeight, point);
      const double way = (center - point).cross(towardsSun).norm();  // of the line to the sun past the centre
      const int seen = brightness(image, static_cast<int>(pixel.x()), static_cast<int>(pixel.y()));
      if (way < 0.88 * kRadius) {
        EXPECT_LT(seen, 25) << point.transpose();
      }
      if (way > 1.12 * kRadius) {
        EXPECT_GT(seen, 120) << point.transpose();
      }
      dark += way < 0.88 * kRadius;
      lit += way > 1.12 * kRadius;
    }
  }
  EXPECT_GT(dark, 100);
  EXPECT_GT(lit, 1000);
}

TEST(Render, GivesTheSameBitsForEveryThreadCount) {
  const RenderScene scene = mixedScene();
  const Camera camera = frameBox(boundsOf(scene), 16.0 / 9.0);
  RenderSettings settings{.width = 160, .height = 90, .threads = 1};
  const Image one = render(scene, camera, settings);
  for (const int threads : {2, 3, 8}) {
    settings.threads = threads;
    EXPECT_EQ(render(scene, camera, settings).pixels, one.pixels) << threads << " threads";
  }
}

TEST(Render, RefusesASphereWithoutSizeByName) {
  RenderScene scene;
  scene.spheres = {{Vector3::Zero(), 1.0}, {Vector3::Zero(), -0.5}};
  const std::string message = messageOf<std::invalid_argument>([&] { render(scene, Camera{}, {}); });
  EXPECT_NE(message.find("spheres[1].radius is -0.5 m"), std::string::npos) << message;
}

TEST(Render, RefusesAMeshThatNamesAMissingVertex) {
  RenderScene scene;
  scene.meshes = {
      {.mesh = shared({.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, .triangles = {{0, 1, 3}}})}};
  const std::string message = messageOf<std::invalid_argument>([&] { render(scene, Camera{}, {}); });
  EXPECT_NE(message.find("vertex index is 3"), std::string::npos) << message;
}

TEST(RayScene, FindsASphereAtTheDistanceOfTheFormula) {
  RenderScene scene{.spheres = {{{3, 4, -10}, 2.0}}};
  const RayScene rays(scene, Vector3(3, 3, 0));  // the sphere's centre is 1 above the ray
  Hit hit;
  ASSERT_TRUE(rays.closestOpaque({Vector3f::Zero(), -Vector3f::UnitZ()}, kInfinity, hit));
  EXPECT_NEAR(hit.distance, 10.0 - std::sqrt(3.0), 1e-5);
  EXPECT_NEAR(hit.normal.y(), -0.5, 1e-5);  // 1 below the centre, of radius 2
  EXPECT_FALSE(rays.closestOpaque({Vector3f::Zero(), Vector3f::UnitZ()}, kInfinity, hit));
}

TEST(RayScene, PlacesAMeshAtItsPose) {
  RenderScene scene;
  const Quaternion quarterTurn(Eigen::AngleAxisd(0.5 * std::numbers::pi, Vector3::UnitZ()));
  scene.meshes = {{.mesh = shared(granular::makeBox({4, 1, 1})), .pose = {Vector3(0, 0, -5), quarterTurn}}};
  const RayScene rays(scene, Vector3::Zero());
  Hit hit;
  ASSERT_TRUE(
      rays.closestOpaque({Vector3f(0, 1.9f, 0), -Vector3f::UnitZ()}, kInfinity, hit));  // long side is up now
  EXPECT_NEAR(hit.distance, 4.5, 1e-5);
  EXPECT_NEAR(hit.normal.z(), 1.0, 1e-5);
  EXPECT_FALSE(rays.closestOpaque({Vector3f(0.6f, 0, 0), -Vector3f::UnitZ()}, kInfinity, hit));
}

// Straight through one face of glass of index 1.5: 4 % is reflected, and `opacity` of the rest is taken away.
TEST(RayScene, ThinGlassPassesTheShareItsOpacitySays) {
  RenderScene scene;
  scene.meshes = {{.mesh = shared(granular::makePlanePatch(1, 1)),
                   .surface = {.color = Color::Ones(), .opacity = 0.3, .glass = Glass::thin}}};
  const RayScene rays(scene, Vector3(0, 0, 2));
  const Color share = rays.transmittance({Vector3f(0.1f, 0.2f, 0), -Vector3f::UnitZ()}, kInfinity);
  EXPECT_NEAR(share.x(), 0.96 * 0.7, 1e-5);
  EXPECT_NEAR(share.z(), 0.96 * 0.7, 1e-5);
}

// Twice the thickness squares the share: Beer and Lambert. Two faces reflect.
TEST(RayScene, SolidGlassTakesLightByTheLengthOfTheWay) {
  RenderScene scene;
  scene.meshes = {{.mesh = shared(granular::makeBox({1, 1, 0.5})),
                   .surface = {.color = Color::Ones(), .opacity = 0.3, .glass = Glass::solid}}};
  const RayScene rays(scene, Vector3::Zero());
  const float across = rays.transmittance({Vector3f(0.1f, 0.2f, 3), -Vector3f::UnitZ()}, kInfinity).x();
  const float along = rays.transmittance({Vector3f(3, 0.2f, 0.1f), -Vector3f::UnitX()}, kInfinity).x();
  EXPECT_NEAR(across, 0.96 * 0.96 * 0.7, 1e-4);
  EXPECT_NEAR(along, 0.96 * 0.96 * 0.7 * 0.7, 1e-4);
}

TEST(RayScene, AnOpaqueThingBlocksAllLightBehindGlass) {
  RenderScene scene{.spheres = {{{0, 0, -5}, 1.0}}};
  scene.meshes = {{.mesh = shared(granular::makePlanePatch(1, 1)), .surface = {.opacity = 0.3}}};
  const RayScene rays(scene, Vector3(0, 0, 2));
  EXPECT_EQ(rays.transmittance({Vector3f::Zero(), -Vector3f::UnitZ()}, kInfinity).maxCoeff(), 0.0f);
}

/// What arrives from the top of a chalk sphere under a sun in the zenith, seen from above at 45 degrees.
LightSample lightFromTheTopOfASphere(const Surface& surface, const Sky& sky, double sunIrradiance) {
  RenderScene scene;
  scene.ground.reset();
  scene.spheres = {{Vector3(0, -1, 0), 1.0, Color::Ones(), 0}};
  scene.sphereSurfaces = {surface};
  scene.sky = sky;
  scene.sun = {.towards = Vector3::UnitY(), .color = Color::Ones(), .irradiance = sunIrradiance};
  scene.sun.angularRadiusDegrees = 0.0;
  const Camera camera{.eye = {2, 2, 0}, .target = {0, 0, 0}};
  const RayScene rays(scene, camera.eye);
  const Environment environment(scene, camera);
  return PathTracer(rays, environment, {.ambientRays = 16})
      .trace({Vector3f::Zero(), Vector3f(-1, -1, 0).normalized()}, 0);
}

// Lambert: radiance = albedo / pi * irradiance. Chalk's gloss adds little: 4 % of a lobe spread over the
// hemisphere.
TEST(PathTracer, ChalkInTheSunIsAsBrightAsLambertSays) {
  constexpr double kIrradiance = 3.0;
  const Surface chalk{.color = srgbFromLinear(Color::Constant(0.5f)), .roughness = 1.0};
  const LightSample light = lightFromTheTopOfASphere(chalk, evenSky(Color::Zero()), kIrradiance);
  const double lambert = 0.5 / std::numbers::pi * kIrradiance;
  EXPECT_GE(light.radiance().y(), lambert - 1e-5);
  EXPECT_LE(light.radiance().y(), lambert + 0.05 / std::numbers::pi * kIrradiance);
}

TEST(PathTracer, AFaceTurnedToAnEvenSkyReceivesItsRadiance) {
  const LightSample light = lightFromTheTopOfASphere({.roughness = 1.0}, evenSky(Color::Constant(0.6f)), 0.0);
  EXPECT_NEAR(light.ambient.x(), linearFromSrgb(Color::Constant(0.6f)).x(), 1e-5);
}

// A perfect mirror shows the sky as it is.
TEST(PathTracer, ASmoothWhiteMetalShowsTheSkyUndimmed) {
  const Surface mirror{.color = Color::Ones(), .roughness = 0.0, .metallic = 1.0};
  const LightSample light = lightFromTheTopOfASphere(mirror, evenSky(Color::Constant(0.6f)), 0.0);
  EXPECT_NEAR(light.radiance().x(), linearFromSrgb(Color::Constant(0.6f)).x(), 0.02);
}

// Integral of the specular lobe over the hemisphere, by brute force. No surface reflects more than it
// receives, and a smooth one reflects all that meets it.
TEST(GgxSpecular, ReflectsNoMoreThanArrives) {
  const Vector3f normal = Vector3f::UnitZ();
  for (const double alpha : {0.1, 0.3, 0.7, 1.0}) {
    for (const double viewAngle : {0.1, 0.8, 1.3}) {
      const Vector3f toViewer(static_cast<float>(std::sin(viewAngle)), 0,
                              static_cast<float>(std::cos(viewAngle)));
      constexpr int kSteps = 600;
      double sum = 0.0;
      for (int i = 0; i < kSteps; ++i) {
        const double theta = (i + 0.5) * 0.5 * std::numbers::pi / kSteps;
        for (int j = 0; j < kSteps; ++j) {
          const double phi = (j + 0.5) * 2.0 * std::numbers::pi / kSteps;
          const Eigen::Vector3d light(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi),
                                      std::cos(theta));
          sum += ggxSpecular(normal, toViewer, light.cast<float>(), static_cast<float>(alpha)) *
                 std::sin(theta) * std::cos(theta);
        }
      }
      const double reflected = sum * std::numbers::pi * std::numbers::pi / (kSteps * kSteps);
      EXPECT_LT(reflected, 1.005) << "alpha " << alpha << ", view " << viewAngle;
      if (alpha <= 0.1 && viewAngle < 1.0) {
        EXPECT_GT(reflected, 0.97);
      }
    }
  }
}

// The defining property of a (0, 2)-sequence: 16 consecutive points put one into each box of area 1/16 of
// every shape 2^-a x 2^-b, a + b = 4, for every aligned block and dimension pair.
TEST(SamplePair, IsEvenlySpreadInEveryShapeOfBox) {
  for (const std::uint32_t dimension : {0u, 1u, 7u}) {
    for (const std::uint32_t block : {0u, 5u, 123456u}) {
      for (int a = 0; a <= 4; ++a) {
        std::set<std::pair<int, int>> boxes;
        for (std::uint32_t i = 0; i < 16; ++i) {
          const Sample2 s = samplePair(16 * block + i, dimension);
          boxes.insert({static_cast<int>(s.x * static_cast<float>(1 << a)),
                        static_cast<int>(s.y * static_cast<float>(1 << (4 - a)))});
        }
        EXPECT_EQ(boxes.size(), 16u) << "dimension " << dimension << ", block " << block << ", shape " << a;
      }
    }
  }
}

TEST(CornerNormals, KeepTheEdgesOfACubeSharp) {
  const TriangleMesh cube = granular::makeBox({1, 1, 1}, 2);
  const auto normals = cornerNormals(cube);
  for (std::size_t i = 0; i < cube.triangles.size(); ++i) {
    const Eigen::Vector3f face = doubleAreaVector(cube, cube.triangles[i]).normalized().cast<float>();
    for (const auto& normal : normals[i]) EXPECT_LT((normal - face).norm(), 1e-6f);
  }
}

TEST(CornerNormals, PointAwayFromTheCentreOfARoundMesh) {
  TriangleMesh loose;  // every triangle with vertices of its own, as in an STL file
  const TriangleMesh ball = granular::makeIcosphere(0.3, 3);
  for (const auto& triangle : ball.triangles) {
    const auto first = static_cast<std::int32_t>(loose.vertices.size());
    for (const std::int32_t v : triangle)
      loose.vertices.push_back(ball.vertices[static_cast<std::size_t>(v)]);
    loose.triangles.push_back({first, first + 1, first + 2});
  }
  const auto normals = cornerNormals(loose);
  for (std::size_t i = 0; i < normals.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_GT(normals[i][k].dot(loose.vertices[3 * i + k].normalized().cast<float>()), 0.999f);
}

TEST(Viridis, RunsFromThePublishedVioletToThePublishedYellow) {
  const Color violet(0x44 / 255.0f, 0x01 / 255.0f, 0x54 / 255.0f),
      yellow(0xfd / 255.0f, 0xe7 / 255.0f, 0x25 / 255.0f);
  EXPECT_LT((viridis(0.0) - violet).abs().maxCoeff(), 0.02f);
  EXPECT_LT((viridis(1.0) - yellow).abs().maxCoeff(), 0.02f);
  EXPECT_TRUE((viridis(-3.0) == viridis(0.0)).all());
}

TEST(Viridis, GrowsSteadilyBrighter) {
  for (int i = 0; i < 100; ++i)
    EXPECT_LT(luminance(linearFromSrgb(viridis(i / 100.0))),
              luminance(linearFromSrgb(viridis((i + 1) / 100.0))));
}

TEST(Tone, SrgbCurveIsUndoneByItsInverse) {
  for (int i = 0; i <= 255; ++i) {
    const Color value = Color::Constant(static_cast<float>(i) / 255.0f);
    EXPECT_NEAR(srgbFromLinear(linearFromSrgb(value)).x(), value.x(), 1e-5f);
  }
}

TEST(Tone, FilmicCurveRisesFromBlackAndNeverPassesWhite) {
  EXPECT_EQ(filmic(Color::Zero()).x(), 0.0f);
  float before = 0.0f;
  for (float light = 0.005f; light < 4.0f; light *= 1.05f) {
    const float shown = filmic(Color::Constant(light)).x();
    EXPECT_GT(shown, before);
    EXPECT_LE(shown, 1.0f);
    before = shown;
  }
}

Image noisyImage(int width, int height) {
  Image image{width, height, {}};
  Random random(5);
  for (int i = 0; i < 3 * width * height; ++i)
    image.pixels.push_back(static_cast<std::uint8_t>(random.bits() & 0xff));
  return image;
}

TEST_F(ImageFile, IsReadBackWithTheSamePixels) {
  const Image image = noisyImage(37, 23);
  writePng(image, folder_ / "picture.png");
  const Image again = readPng(folder_ / "picture.png");
  EXPECT_EQ(again.width, 37);
  EXPECT_EQ(again.height, 23);
  EXPECT_EQ(again.pixels, image.pixels);
}

TEST_F(ImageFile, ThatCannotBeWrittenIsNamed) {
  const fs::path path = folder_ / "no such folder" / "picture.png";
  const std::string message = messageOf<std::runtime_error>([&] { writePng(noisyImage(4, 4), path); });
  EXPECT_NE(message.find(path.string()), std::string::npos) << message;
}

TEST_F(ImageFile, ThatIsNoPngIsRefused) {
  std::ofstream(folder_ / "text.png") << "not a picture";
  EXPECT_THROW(readPng(folder_ / "text.png"), std::runtime_error);
}

bool ffmpegIsInstalled() {
  return std::system("ffmpeg -version > /dev/null 2>&1") == 0;
}

void writeFrames(const fs::path& folder, int count) {
  for (int i = 0; i < count; ++i) writePng(noisyImage(33, 25), framePath(folder, i));  // odd on purpose
}

TEST_F(FilmFile, IsAnMp4WithItsIndexInFront) {
  ASSERT_TRUE(ffmpegIsInstalled()) << "the set-up installs ffmpeg";
  const fs::path frames =
      folder_ / "it's 100%d; touch \"x\" $(here)";  // a shell or a pattern would trip over it
  fs::create_directory(frames);
  writeFrames(frames, 5);
  const fs::path film = writeFilm({.frameFolder = frames, .file = frames / "film.mp4"});
  EXPECT_EQ(film, frames / "film.mp4");
  std::stringstream bytes;
  bytes << std::ifstream(film, std::ios::binary).rdbuf();
  EXPECT_EQ(bytes.str().find("ftyp"), 4u);
  EXPECT_LT(bytes.str().find("moov"), bytes.str().find("mdat"));
}

TEST_F(FilmFile, WithoutFfmpegSaysWhatIsMissing) {
  writeFrames(folder_, 1);
  const ScopedVariable path("PATH", (folder_ / "empty").string());
  const std::string message = messageOf<std::runtime_error>(
      [&] { writeFilm({.frameFolder = folder_, .file = folder_ / "film.mp4"}); });
  EXPECT_NE(message.find("'ffmpeg' on PATH"), std::string::npos) << message;
}

TEST_F(FilmFile, ThatFfmpegCannotMakePassesItsWordsOn) {
  ASSERT_TRUE(ffmpegIsInstalled()) << "the set-up installs ffmpeg";
  std::ofstream(framePath(folder_, 0)) << "not a picture";
  const std::string message = messageOf<std::runtime_error>(
      [&] { writeFilm({.frameFolder = folder_, .file = folder_ / "film.mp4"}); });
  EXPECT_NE(message.find("ended with code"), std::string::npos) << message;
  EXPECT_NE(message.find("PNG"), std::string::npos) << message;
}

TEST_F(FilmFile, OfAFolderWithoutFramesIsRefused) {
  const std::string message = messageOf<std::invalid_argument>(
      [&] { writeFilm({.frameFolder = folder_, .file = folder_ / "film.mp4"}); });
  EXPECT_NE(message.find("frame_00000.png"), std::string::npos) << message;
}

TEST(AxisTicks, OfManyDecadesLabelPowersOfTen) {
  std::vector<double> labelled;
  for (const Tick& tick : ticksOf({Scale::logarithmic, 2e-4, 3e2}, 8))
    if (!tick.label.empty()) labelled.push_back(std::log10(tick.value));
  ASSERT_EQ(labelled.size(), 6u);
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(labelled[static_cast<std::size_t>(i)], i - 3.0, 1e-9);
}

TEST(AxisTicks, OfALinearAxisStepByOneTwoOrFive) {
  const auto ticks = ticksOf({Scale::linear, -0.03, 1.04}, 6);
  ASSERT_EQ(ticks.size(), 6u);
  for (std::size_t i = 0; i < ticks.size(); ++i)
    EXPECT_NEAR(ticks[i].value, 0.2 * static_cast<double>(i), 1e-12);
  EXPECT_EQ(ticks[0].label, "0");
  EXPECT_EQ(ticks[2].label, "0.4");
}

/// Mean place of the pixels of about this colour.
Eigen::Vector2d placeOf(const Image& image, const Color& color) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  int count = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const auto p = image.at(x, y);
      const Color seen = Color(p[0], p[1], p[2]) / 255.0f;
      if ((seen - color).abs().maxCoeff() > 0.02f) continue;
      sum += Eigen::Vector2d(x, y);
      ++count;
    }
  }
  return sum / count;  // not a number when there is none: fails every comparison
}

// Points at 1, 10 and 100 on logarithmic axes lie on a line, evenly spaced, rising to the right.
TEST_F(FigureFile, PutsPointsWhereLogarithmicAxesSay) {
  const Color red(0.9f, 0.1f, 0.1f), green(0.1f, 0.7f, 0.1f), blue(0.1f, 0.1f, 0.9f);
  const auto point = [](double x, double y, const Color& color) {
    return Series{
        .name = "", .x = {x}, .y = {y}, .line = Line::none, .marker = Marker::square, .color = color};
  };
  const Panel panel{.title = "points",
                    .x = {"x", Scale::logarithmic},
                    .y = {"y", Scale::logarithmic},
                    .series = {point(1, 3, red), point(10, 30, green), point(100, 300, blue)}};
  writeFigure({.panels = {panel}}, folder_ / "figure.png");
  const Image image = readPng(folder_ / "figure.png");
  EXPECT_EQ(image.width, 920);
  EXPECT_EQ(image.height, 680);
  const Eigen::Vector2d low = placeOf(image, red), middle = placeOf(image, green),
                        high = placeOf(image, blue);
  EXPECT_LT((0.5 * (low + high) - middle).norm(), 1.0);
  EXPECT_GT(high.x() - low.x(), 400.0);
  EXPECT_LT(high.y() - low.y(), -300.0);
}

TEST_F(FigureFile, RefusesASeriesOfUnequalLengths) {
  const Figure figure{.panels = {{.series = {{.name = "speed", .x = {1, 2, 3}, .y = {1, 2}}}}}};
  const std::string message =
      messageOf<std::invalid_argument>([&] { writeFigure(figure, folder_ / "figure.png"); });
  EXPECT_NE(message.find("speed"), std::string::npos) << message;
}

TEST_F(FigureFile, RefusesALogarithmicAxisWithoutAPositiveValue) {
  const Figure figure{
      .panels = {{.title = "loss", .y = {"y", Scale::logarithmic}, .series = {{.x = {1, 2}, .y = {0, -1}}}}}};
  const std::string message =
      messageOf<std::invalid_argument>([&] { writeFigure(figure, folder_ / "figure.png"); });
  EXPECT_NE(message.find("Axis y of panel 'loss'"), std::string::npos) << message;
}

TEST_F(FigureFile, ThatCannotBeWrittenIsNamed) {
  const Figure figure{.panels = {{.series = {{.x = {1, 2}, .y = {1, 2}}}}}};
  const fs::path path = folder_ / "missing" / "figure.png";
  const std::string message = messageOf<std::runtime_error>([&] { writeFigure(figure, path); });
  EXPECT_NE(message.find(path.string()), std::string::npos) << message;
}

}  // namespace
}  // namespace granular_demo
