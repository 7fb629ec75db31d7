// SPDX-License-Identifier: MIT
#include "granular/io/vtp_writer.h"

#include <map>
#include <numeric>

#include "granular/base/require.h"
#include "granular/io/detail/first_particles.h"
#include "granular/io/detail/vtp_file.h"

namespace granular {
namespace {

using detail::AppendedData;
using detail::byteOrder;
using detail::flattened;
using detail::write;
using detail::writePolyData;

void checkLengths(const PointCloud& cloud) {
  const std::size_t count = cloud.positions.size();
  const auto check = [count](std::size_t size, const char* name) {
    require(size == 0 || size == count, std::string("PointCloud.") + name, size, "entries",
            "0 or as many as positions");
  };
  check(cloud.radius.size(), "radius");
  check(cloud.velocity.size(), "velocity");
  check(cloud.ownerKind.size(), "ownerKind");
  check(cloud.owner.size(), "owner");
  check(cloud.material.size(), "material");
  check(cloud.force.size(), "force");
}

void addPointData(const PointCloud& cloud, AppendedData& data) {
  data.line("      <PointData>");
  if (!cloud.radius.empty())
    data.add("radius", 1, std::vector<float>(cloud.radius.begin(), cloud.radius.end()));
  if (!cloud.velocity.empty()) data.add("velocity", 3, flattened<float>(cloud.velocity));
  if (!cloud.force.empty()) data.add("force", 3, flattened<float>(cloud.force));
  if (!cloud.ownerKind.empty()) data.add("ownerKind", 1, cloud.ownerKind);
  if (!cloud.owner.empty()) data.add("owner", 1, cloud.owner);
  if (!cloud.material.empty()) data.add("material", 1, cloud.material);
  data.line("      </PointData>");
}

void addGeometry(const PointCloud& cloud, AppendedData& data) {
  data.line("      <Points>");
  data.add("Points", 3, flattened<double>(cloud.positions));
  data.line("      </Points>");
  std::vector<std::int32_t> indices(cloud.positions.size());
  std::iota(indices.begin(), indices.end(), 0);
  data.line("      <Verts>");
  data.add("connectivity", 1, indices);
  std::iota(indices.begin(), indices.end(), 1);
  data.add("offsets", 1, indices);
  data.line("      </Verts>");
}

/// Sum of contact forces on each particle, N; empty if there are no contacts.
std::vector<Vector3> contactForces(std::span<const ParticleView> particles,
                                   std::span<const ContactView> contacts) {
  if (contacts.empty()) return {};
  const detail::FirstParticles first(particles);
  std::vector<Vector3> forces(particles.size(), Vector3::Zero());
  for (const ContactView& contact : contacts) {
    for (int side = 0; side < 2; ++side) {
      const std::int64_t i = first.of(contact, side);
      if (i >= 0) forces[i] += side == 0 ? contact.force : Vector3(-contact.force);
    }
  }
  return forces;
}

}  // namespace

PointCloud particleCloud(const GranularSystem& system, std::span<const CloudBody> bodies,
                         std::span<const ContactView> contacts) {
  std::map<std::int32_t, CloudBody> listed;
  for (const CloudBody& body : bodies) listed[body.id.index] = body;
  std::vector<ParticleView> particles;
  system.readParticles(particles);
  const std::vector<Vector3> forces = contactForces(particles, contacts);
  PointCloud cloud;
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const ParticleView& p = particles[i];
    RigidMotion motion;
    MaterialId material;
    if (p.ownerKind == OwnerKind::Grain) {
      motion = system.grainMotions()[p.ownerIndex];
      material = system.materialOf(system.grainAt(p.ownerIndex));
    } else {
      const auto body = listed.find(p.ownerIndex);
      if (body == listed.end()) continue;
      motion = system.bodyMotion(body->second.id);
      material = body->second.material;
    }
    cloud.positions.push_back(p.position);
    cloud.radius.push_back(p.radius);
    cloud.velocity.push_back(motion.velocity +
                             motion.angularVelocity.cross(p.position - motion.pose.position));
    cloud.ownerKind.push_back(static_cast<std::int32_t>(p.ownerKind));
    cloud.owner.push_back(p.ownerIndex);
    cloud.material.push_back(material.index);
    if (!forces.empty()) cloud.force.push_back(forces[i]);
  }
  return cloud;
}

void writeVtp(const std::filesystem::path& file, const PointCloud& cloud) {
  checkLengths(cloud);
  AppendedData data;
  addPointData(cloud, data);
  addGeometry(cloud, data);
  writePolyData(file, cloud.positions.size(), cloud.positions.size(), 0, data);
}

void writePvd(const std::filesystem::path& file, const std::vector<std::pair<double, std::string>>& series) {
  std::ostringstream text;
  text.precision(17);
  text << "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"" << byteOrder()
       << "\">\n  <Collection>\n";
  for (const auto& [time, path] : series) {
    text << "    <DataSet timestep=\"" << time << "\" part=\"0\" file=\"" << path << "\"/>\n";
  }
  text << "  </Collection>\n</VTKFile>\n";
  write(file, text.str());
}

}  // namespace granular
