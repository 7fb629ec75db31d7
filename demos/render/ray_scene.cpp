// SPDX-License-Identifier: MIT
#include "demos/render/ray_scene.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>

#include "demos/render/mesh_normals.h"
#include "demos/render/tone.h"
#include "granular/base/require.h"

namespace granular_demo {
namespace {

struct ReleaseDevice {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
};
struct ReleaseScene {
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};
using DeviceOwner = std::unique_ptr<RTCDeviceTy, ReleaseDevice>;
using SceneOwner = std::unique_ptr<RTCSceneTy, ReleaseScene>;

/// A mesh in its own frame, shared by its instances.
struct MeshData {
  SceneOwner scene;
  std::vector<std::array<Vector3f, 3>> normals;
  float size = 0;       // m, diagonal of its box
  float thickness = 0;  // m, smallest side of its box
};

struct SphereData {
  Vector3f center;
  float radius;
  Color color;
  std::int32_t surface;
};

struct InstanceData {
  const MeshData* mesh;
  Eigen::Matrix3f rotation;
  Material material;
};

/// What one Embree scene holds; geometry 0 is the spheres, geometry 1 + i is instance i.
struct Layer {
  SceneOwner scene;
  std::vector<SphereData> spheres;
  std::vector<InstanceData> instances;

  bool empty() const { return spheres.empty() && instances.empty(); }
};

void checkShare(double value, const std::string& field) {
  granular::require(value >= 0.0 && value <= 1.0, field, value, "", "in [0, 1]");
}

/// @param thickness  way through solid glass that takes away 1 - opacity, m; 0 for a surface without volume
Material materialOf(const Surface& surface, double thickness, const std::string& field) {
  checkShare(surface.roughness, field + ".roughness");
  checkShare(surface.metallic, field + ".metallic");
  checkShare(surface.opacity, field + ".opacity");
  Material material;
  material.color = linearFromSrgb(surface.color);
  material.roughness = static_cast<float>(surface.roughness);
  material.alpha = std::max(material.roughness * material.roughness, 1e-3f);
  material.metallic = static_cast<float>(surface.metallic);
  material.isGlass = surface.opacity < 1.0;
  if (!material.isGlass) return material;
  const Color lost = 1.0f - material.color;
  const float mean = lost.mean();
  material.extinction =
      (mean > 1e-4f ? Color(lost / mean) : Color::Ones()) * -std::log1p(-static_cast<float>(surface.opacity));
  material.glass = thickness > 0.0 ? surface.glass : Glass::thin;
  if (material.glass == Glass::solid) material.extinction /= static_cast<float>(thickness);
  return material;
}

/// A ray at the hit of which the result of Embree is read.
RTCRayHit embreeRay(const Ray& ray, float farthest) {
  RTCRayHit query{};
  query.ray = {ray.origin.x(),
               ray.origin.y(),
               ray.origin.z(),
               0.0f,
               ray.direction.x(),
               ray.direction.y(),
               ray.direction.z(),
               0.0f,
               farthest,
               0xffffffffu,
               0,
               0};
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  return query;
}

}  // namespace

Color thinTransmission(const Material& material, float cosine) {
  const float insideSineSquared = (1.0f - cosine * cosine) / (kGlassIndex * kGlassIndex);
  return (-material.extinction / std::sqrt(1.0f - insideSineSquared)).exp();
}

Color solidTransmission(const Material& material, float distance) {
  return (-material.extinction * distance).exp();
}

struct RayScene::Impl {
  DeviceOwner device;
  std::map<const granular::TriangleMesh*, MeshData> meshes;
  std::vector<Material> sphereMaterials;
  Layer opaque, glass;

  Impl(const RenderScene& scene, const Vector3& origin);
  void addSpheres(const RenderScene& scene, const Vector3& origin);
  void addInstances(const RenderScene& scene, const Vector3& origin);
  const MeshData& meshData(const granular::TriangleMesh& mesh, const std::string& field);
  void commit(Layer& layer);
  bool closest(const Layer& layer, const Ray& ray, float farthest, Hit& hit) const;
  void sphereHit(const SphereData& sphere, const Ray& ray, Hit& hit) const;
  void meshHit(const InstanceData& instance, const RTCHit& found, const Ray& ray, Hit& hit) const;
};

RayScene::Impl::Impl(const RenderScene& scene, const Vector3& origin) {
  // One build thread: the tree, and with it ties between equal distances, must not depend on the machine's
  // load.
  device.reset(rtcNewDevice("threads=1"));
  if (!device)
    throw std::runtime_error("Embree has no device: error " + std::to_string(rtcGetDeviceError(nullptr)));
  opaque.scene.reset(rtcNewScene(device.get()));
  glass.scene.reset(rtcNewScene(device.get()));
  addSpheres(scene, origin);
  addInstances(scene, origin);
  commit(opaque);
  commit(glass);
  if (const RTCError error = rtcGetDeviceError(device.get()); error != RTC_ERROR_NONE)
    throw std::runtime_error("Embree cannot build the scene: error " + std::to_string(error));
}

void RayScene::Impl::addSpheres(const RenderScene& scene, const Vector3& origin) {
  for (std::size_t i = 0; i < scene.sphereSurfaces.size(); ++i)
    sphereMaterials.push_back(
        materialOf(scene.sphereSurfaces[i], 1.0, "RenderScene.sphereSurfaces[" + std::to_string(i) + "]"));
  for (std::size_t i = 0; i < scene.spheres.size(); ++i) {
    const RenderSphere& sphere = scene.spheres[i];
    const bool fine = sphere.position.allFinite() && std::isfinite(sphere.radius) && sphere.radius > 0.0 &&
                      sphere.surface >= 0 &&
                      static_cast<std::size_t>(sphere.surface) < sphereMaterials.size();
    if (!fine) {
      const std::string field = "RenderScene.spheres[" + std::to_string(i) + "]";
      granular::requireFinite(sphere.position, field + ".position", "m");
      granular::requirePositive(sphere.radius, field + ".radius", "m");
      granular::require(false, field + ".surface", sphere.surface, "", "an index into sphereSurfaces");
    }
    const Material& material = sphereMaterials[static_cast<std::size_t>(sphere.surface)];
    Layer& layer = material.isGlass ? glass : opaque;
    layer.spheres.push_back({(sphere.position - origin).cast<float>(), static_cast<float>(sphere.radius),
                             linearFromSrgb(sphere.color), sphere.surface});
  }
}

void RayScene::Impl::addInstances(const RenderScene& scene, const Vector3& origin) {
  for (std::size_t i = 0; i < scene.meshes.size(); ++i) {
    const MeshInstance& instance = scene.meshes[i];
    const std::string field = "RenderScene.meshes[" + std::to_string(i) + "]";
    granular::require(instance.mesh != nullptr, field + ".mesh", "null", "", "a mesh");
    granular::requireFinite(instance.pose.position, field + ".pose.position", "m");
    granular::requireRotation(instance.pose.orientation, field + ".pose.orientation");
    const MeshData& mesh = meshData(*instance.mesh, field);
    const bool flat = mesh.thickness < 1e-4f * mesh.size;
    const Material material = materialOf(instance.surface, flat ? 0.0 : mesh.thickness, field + ".surface");
    Layer& layer = material.isGlass ? glass : opaque;
    const Eigen::Matrix3f rotation = instance.pose.orientation.toRotationMatrix().cast<float>();
    layer.instances.push_back({&mesh, rotation, material});

    Eigen::Matrix<float, 3, 4> placement;  // column major, as Embree wants it
    placement << rotation, (instance.pose.position - origin).cast<float>();
    RTCGeometry geometry = rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(geometry, mesh.scene.get());
    rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, placement.data());
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(layer.scene.get(), geometry, static_cast<unsigned>(layer.instances.size()));
    rtcReleaseGeometry(geometry);
  }
}

const MeshData& RayScene::Impl::meshData(const granular::TriangleMesh& mesh, const std::string& field) {
  const auto [entry, isNew] = meshes.try_emplace(&mesh);
  MeshData& data = entry->second;
  if (!isNew) return data;
  granular::require(!mesh.triangles.empty(), field + ".mesh->triangles.size()", 0, "", "> 0");
  const auto vertexCount = static_cast<std::int32_t>(mesh.vertices.size());
  for (const auto& triangle : mesh.triangles)
    for (const std::int32_t v : triangle)
      granular::require(v >= 0 && v < vertexCount, field + ".mesh->triangles: vertex index", v, "",
                        "an existing vertex");

  Eigen::AlignedBox3d box;
  for (const Vector3& v : mesh.vertices) box.extend(v);
  data.size = static_cast<float>(box.diagonal().norm());
  data.thickness = static_cast<float>(box.sizes().minCoeff());
  data.normals = cornerNormals(mesh);

  RTCGeometry geometry = rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), mesh.vertices.size()));
  for (const Vector3& v : mesh.vertices)
    for (int axis = 0; axis < 3; ++axis) *vertices++ = static_cast<float>(v[axis]);
  auto* indices = static_cast<unsigned*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(unsigned), mesh.triangles.size()));
  for (const auto& triangle : mesh.triangles)
    for (const std::int32_t v : triangle) *indices++ = static_cast<unsigned>(v);
  rtcCommitGeometry(geometry);
  data.scene.reset(rtcNewScene(device.get()));
  rtcSetSceneFlags(data.scene.get(), RTC_SCENE_FLAG_ROBUST);  // no light through the edges
  rtcAttachGeometryByID(data.scene.get(), geometry, 0);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(data.scene.get());
  return data;
}

void RayScene::Impl::commit(Layer& layer) {
  if (!layer.spheres.empty()) {
    RTCGeometry geometry = rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_SPHERE_POINT);
    auto* out = static_cast<float*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, 4 * sizeof(float), layer.spheres.size()));
    for (const SphereData& sphere : layer.spheres) {
      for (int axis = 0; axis < 3; ++axis) *out++ = sphere.center[axis];
      *out++ = sphere.radius;
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(layer.scene.get(), geometry, 0);
    rtcReleaseGeometry(geometry);
  }
  rtcCommitScene(layer.scene.get());
}

bool RayScene::Impl::closest(const Layer& layer, const Ray& ray, float farthest, Hit& hit) const {
  if (layer.empty()) return false;
  RTCRayHit query = embreeRay(ray, farthest);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(layer.scene.get(), &context, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
  hit.distance = query.ray.tfar;
  const unsigned instance = query.hit.instID[0];
  if (instance == RTC_INVALID_GEOMETRY_ID) {
    sphereHit(layer.spheres[query.hit.primID], ray, hit);
  } else {
    meshHit(layer.instances[instance - 1], query.hit, ray, hit);
  }
  return true;
}

void RayScene::Impl::sphereHit(const SphereData& sphere, const Ray& ray, Hit& hit) const {
  const Vector3f outward = (ray.origin + hit.distance * ray.direction - sphere.center).normalized();
  hit.position = sphere.center + sphere.radius * outward;
  hit.entering = outward.dot(ray.direction) < 0.0f;
  hit.normal = hit.entering ? outward : Vector3f(-outward);
  hit.material = sphereMaterials[static_cast<std::size_t>(sphere.surface)];
  hit.color = hit.material.color * sphere.color;
  hit.offset = 1e-3f * sphere.radius + 1e-6f * hit.distance;
  if (hit.material.glass == Glass::solid) hit.material.extinction /= 2.0f * sphere.radius;
}

void RayScene::Impl::meshHit(const InstanceData& instance, const RTCHit& found, const Ray& ray,
                             Hit& hit) const {
  const Vector3f face = (instance.rotation * Vector3f(found.Ng_x, found.Ng_y, found.Ng_z)).normalized();
  const auto& corners = instance.mesh->normals[found.primID];
  const Vector3f blend =
      (1.0f - found.u - found.v) * corners[0] + found.u * corners[1] + found.v * corners[2];
  hit.entering = face.dot(ray.direction) < 0.0f;
  const float side = hit.entering ? 1.0f : -1.0f;
  const Vector3f smooth = side * (instance.rotation * blend).normalized();
  hit.normal = smooth.dot(ray.direction) < -0.02f ? smooth : Vector3f(side * face);
  hit.position = ray.origin + hit.distance * ray.direction;
  hit.material = instance.material;
  hit.color = instance.material.color;
  hit.offset = 2e-5f * instance.mesh->size + 2e-6f * hit.distance;
}

RayScene::RayScene(const RenderScene& scene, const Vector3& origin)
    : impl_(std::make_unique<Impl>(scene, origin)) {}
RayScene::~RayScene() = default;

bool RayScene::closestOpaque(const Ray& ray, float farthest, Hit& hit) const {
  return impl_->closest(impl_->opaque, ray, farthest, hit);
}

bool RayScene::closestGlass(const Ray& ray, float farthest, Hit& hit) const {
  return impl_->closest(impl_->glass, ray, farthest, hit);
}

Color RayScene::transmittance(const Ray& ray, float farthest) const {
  if (!impl_->opaque.empty()) {
    RTCRay query = embreeRay(ray, farthest).ray;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded1(impl_->opaque.scene.get(), &context, &query);
    if (query.tfar < 0.0f) return Color::Zero();
  }
  return glassTransmittance(ray, farthest);
}

Color RayScene::glassTransmittance(Ray ray, float farthest) const {
  constexpr int kMostFaces = 16;  // a stack of eight panes is as good as a wall
  Color share = Color::Ones();
  Hit hit;
  for (int face = 0; face < kMostFaces && impl_->closest(impl_->glass, ray, farthest, hit); ++face) {
    const float cosine = std::abs(hit.normal.dot(ray.direction));
    share *= 1.0f - glassReflectance(cosine, 1.0f / kGlassIndex);
    if (hit.material.glass == Glass::thin) {
      share *= thinTransmission(hit.material, cosine);
    } else if (!hit.entering) {
      share *= solidTransmission(hit.material, hit.distance);
    }
    const float step = hit.distance + hit.offset;
    ray.origin += step * ray.direction;
    farthest -= step;
  }
  return share;
}

}  // namespace granular_demo
