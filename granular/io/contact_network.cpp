// SPDX-License-Identifier: MIT
#include <numeric>

#include "granular/io/detail/first_particles.h"
#include "granular/io/detail/vtp_file.h"
#include "granular/io/vtp_writer.h"

namespace granular {

void writeContactNetwork(const std::filesystem::path& file, std::span<const ParticleView> particles,
                         std::span<const ContactView> contacts) {
  const detail::FirstParticles first(particles);
  std::vector<Vector3> ends, forces;
  std::vector<float> sizes, overlaps;
  std::vector<std::int32_t> kinds, owners;
  for (const ContactView& contact : contacts) {
    for (int side = 0; side < 2; ++side) {
      const std::int64_t i = first.of(contact, side);
      ends.push_back(i < 0 ? contact.point : particles[i].position);
      kinds.push_back(static_cast<std::int32_t>(contact.ownerKind[side]));
      owners.push_back(contact.ownerIndex[side]);
    }
    forces.push_back(contact.force);
    sizes.push_back(static_cast<float>(contact.force.norm()));
    overlaps.push_back(static_cast<float>(contact.overlap));
  }
  detail::AppendedData data;
  data.line("      <CellData>");
  data.add("force", 3, detail::flattened<float>(forces));
  data.add("forceSize", 1, sizes);
  data.add("overlap", 1, overlaps);
  data.add("ownerKinds", 2, kinds);
  data.add("owners", 2, owners);
  data.line("      </CellData>");
  data.line("      <Points>");
  data.add("Points", 3, detail::flattened<double>(ends));
  data.line("      </Points>");
  std::vector<std::int32_t> indices(ends.size());
  std::iota(indices.begin(), indices.end(), 0);
  std::vector<std::int32_t> offsets(contacts.size());
  for (std::size_t i = 0; i < offsets.size(); ++i) offsets[i] = static_cast<std::int32_t>(2 * (i + 1));
  data.line("      <Lines>");
  data.add("connectivity", 1, indices);
  data.add("offsets", 1, offsets);
  data.line("      </Lines>");
  detail::writePolyData(file, ends.size(), 0, contacts.size(), data);
}

}  // namespace granular
