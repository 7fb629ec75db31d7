// SPDX-License-Identifier: MIT
// A system in the terms of LAMMPS: atoms, rigid bodies, walls, and atom types with the coefficients between
// them.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "granular/io/detail/lammps_contact.h"
#include "granular/io/lammps_writer.h"

namespace granular::detail {

enum class LammpsRole : std::uint8_t { Grain, DynamicBody, FixedBody };

/// What coefficients depend on beside materials.
struct LammpsSize {
  double radius = 0.0;  ///< m; 0: a plane
  double mass = 0.0;    ///< of the owner, kg; 0: held

  friend auto operator<=>(const LammpsSize&, const LammpsSize&) = default;
};

/// Particles of one material and role; their types differ by size alone.
struct LammpsFamily {
  MaterialId material;
  LammpsRole role = LammpsRole::Grain;
  std::vector<LammpsSize> sizes = {};  ///< ascending, each once
  int firstType = 1, typeCount = 1;

  /// Types share out the sizes evenly, in their order.
  int typeOf(const LammpsSize& size) const;
  /// Sizes of a type, first and past the last.
  std::pair<std::size_t, std::size_t> sizesOf(int type) const;
  const LammpsSize& middle(int type) const;
};

struct LammpsAtom {
  Vector3 position, velocity, angularVelocity;  // m, m/s, rad/s, world
  double radius = 0.0, density = 0.0;           // m, kg/m^3
  std::int32_t family = 0;
  LammpsSize size;
  std::int64_t molecule = 0;  ///< number of the rigid body, from 1; 0: none
};

struct LammpsRigidBody {
  double mass = 0.0;  // kg
  RigidMotion motion;
  Vector3 inertia;  ///< principal, kg m^2
  double reach = 0.0;
};

struct LammpsWall {
  MaterialId material;
  Vector3 point, normal;  ///< normal: out of the solid
};

/// Frozen atoms that move on evenly: ids first to last.
struct LammpsMover {
  std::int64_t first = 0, last = 0;
  RigidMotion motion;
};

class LammpsModel {
 public:
  LammpsModel(const GranularSystem& system, int largestTypeCount);

  std::vector<LammpsAtom> atoms;
  std::vector<LammpsRigidBody> rigidBodies;
  std::vector<LammpsWall> walls;
  std::vector<LammpsMover> movers;
  std::vector<LammpsFamily> families;
  std::vector<std::string> notes;
  double coefficientError = 0.0;
  double shortestContactTime = 0.0;  ///< at restitutionSpeed, s

  int typeCount() const { return families.back().firstType + families.back().typeCount - 1; }
  int typeOf(const LammpsAtom& atom) const { return families[atom.family].typeOf(atom.size); }
  const LammpsFamily& familyOf(int type) const;
  /// None where the two never meet, or meet under a law that LAMMPS does not have.
  std::optional<LammpsContact> contact(int typeA, int typeB) const;
  std::optional<LammpsContact> wallContact(const LammpsWall& wall, int type) const;

 private:
  struct Side {
    MaterialId material;
    LammpsRole role;
    LammpsSize size;
  };
  void addGrains();
  void addBodies();
  void addBody(const BodyDef& body);
  void addExactSurface(const BodyDef& body, std::int64_t molecule, double density);
  void addAtom(LammpsAtom atom, const Side& side);
  void noteBody(BodyId id, const BodyDef& body);
  void noteFilters();
  void note(const std::string& text);

  void combineMaterialPairs();
  void makeTypes(int largestTypeCount);
  bool dependsOnSize(const LammpsFamily& family) const;
  void measureContacts();
  void measureContact(const Side& a, const Side& b);
  void noteContact(const LammpsContact& contact);

  bool isByArea(const Side& a, const Side& b) const;
  std::optional<LammpsContact> contact(const Side& a, const Side& b) const;
  PairLaw pairLaw(const Side& a, const Side& b) const;
  const MaterialPair& materialPair(const Side& a, const Side& b) const;
  PairSide pairSide(const Side& side) const;
  Side middleOf(int type) const;
  static Side sideOf(const LammpsWall& wall) { return {wall.material, LammpsRole::FixedBody, {}}; }

  const GranularSystem& system_;
  std::set<std::tuple<std::uint32_t, std::uint32_t, bool>> filters_;  // group, mask, held
  std::map<std::pair<std::int32_t, std::int32_t>, MaterialPair> materialPairs_;
  std::vector<std::pair<LammpsAtom, Side>> exactSpheres_;  // come after the particles
};

}  // namespace granular::detail
