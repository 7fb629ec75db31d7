// SPDX-License-Identifier: MIT
#include "granular/io/vtp_writer.h"

#include <bit>
#include <fstream>
#include <map>
#include <numeric>
#include <sstream>

#include "granular/base/require.h"

namespace granular {
namespace {

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
}

void addPointData(const PointCloud& cloud, AppendedData& data) {
  data.line("      <PointData>");
  if (!cloud.radius.empty())
    data.add("radius", 1, std::vector<float>(cloud.radius.begin(), cloud.radius.end()));
  if (!cloud.velocity.empty()) data.add("velocity", 3, flattened<float>(cloud.velocity));
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

void write(const std::filesystem::path& file, const std::string& text) {
  std::ofstream out(file, std::ios::binary);
  out << text;
  out.close();
  if (!out) throw std::runtime_error(file.string() + " cannot be written");
}

const char* byteOrder() {
  return std::endian::native == std::endian::little ? "LittleEndian" : "BigEndian";
}

}  // namespace

PointCloud particleCloud(const GranularSystem& system, std::span<const CloudBody> bodies) {
  std::map<std::int32_t, CloudBody> listed;
  for (const CloudBody& body : bodies) listed[body.id.index] = body;
  std::vector<ParticleView> particles;
  system.readParticles(particles);
  PointCloud cloud;
  for (const ParticleView& p : particles) {
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
  }
  return cloud;
}

void writeVtp(const std::filesystem::path& file, const PointCloud& cloud) {
  checkLengths(cloud);
  AppendedData data;
  addPointData(cloud, data);
  addGeometry(cloud, data);
  std::ostringstream text;
  text << "<?xml version=\"1.0\"?>\n"
       << "<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"" << byteOrder()
       << "\" header_type=\"UInt64\">\n"
       << "  <PolyData>\n"
       << "    <Piece NumberOfPoints=\"" << cloud.positions.size() << "\" NumberOfVerts=\""
       << cloud.positions.size() << "\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"0\">\n"
       << data.xml() << "    </Piece>\n"
       << "  </PolyData>\n"
       << "  <AppendedData encoding=\"raw\">\n_" << data.bytes() << "\n  </AppendedData>\n</VTKFile>\n";
  write(file, text.str());
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
