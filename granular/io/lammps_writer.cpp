// SPDX-License-Identifier: MIT
#include "granular/io/lammps_writer.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>

#include "granular/base/require.h"
#include "granular/io/detail/lammps_model.h"

namespace granular {
namespace {

using detail::LammpsAtom;
using detail::LammpsContact;
using detail::LammpsFamily;
using detail::LammpsModel;
using detail::LammpsMover;
using detail::LammpsRigidBody;
using detail::LammpsRole;
using detail::LammpsWall;

constexpr int kMostTypes = 24;             // LAMMPS has 32 groups, walls take one a type
constexpr std::size_t kMostMovers = 3;     // and these one each
constexpr double kStepsPerContact = 50.0;  // of the time step that is chosen where none is given
constexpr double kSkinPerRadius = 0.3;     // the same
constexpr double kLargestEvenRatio = 2.0;  // of radii: beyond it LAMMPS shall search by size
constexpr double kAlongAxis = 1e-12;       // a normal is along an axis but for rounding
const char* const kUnmet = "hooke 0 0 damping velocity tangential linear_nohistory 0 0";

/// Text with every digit of its numbers.
class Text {
 public:
  Text() { text_.precision(17); }
  template <class... Parts>
  Text& line(const Parts&... parts) {
    const char* between = "";
    ((text_ << between << parts, between = " "), ...);
    text_ << '\n';
    return *this;
  }
  std::string str() const { return text_.str(); }

 private:
  std::ostringstream text_;
};

std::string vectorText(const Vector3& v) {
  std::ostringstream text;
  text.precision(17);
  text << v.x() << ' ' << v.y() << ' ' << v.z();
  return text.str();
}

std::string numbered(std::string name, std::size_t number) {
  return name.append(std::to_string(number));
}

std::filesystem::path write(const std::filesystem::path& file, const std::string& text) {
  std::ofstream out(file, std::ios::binary);
  out << text;
  out.close();
  if (!out) throw std::runtime_error(file.string() + " cannot be written");
  return file;
}

std::string dataFile(const LammpsModel& model) {
  Box box{model.atoms.front().position, model.atoms.front().position};
  for (const LammpsAtom& atom : model.atoms) {
    box.lower = box.lower.cwiseMin(atom.position - Vector3::Constant(2.0 * atom.radius));
    box.upper = box.upper.cwiseMax(atom.position + Vector3::Constant(2.0 * atom.radius));
  }
  Text text;
  text.line("Grains and covered bodies, SI units\n");
  text.line(model.atoms.size(), "atoms").line(model.typeCount(), "atom types\n");
  for (int axis = 0; axis < 3; ++axis) {
    const std::string name(1, "xyz"[axis]);
    text.line(box.lower[axis], box.upper[axis], name + "lo", name + "hi");
  }
  text.line("\nAtoms # sphere: id type diameter density x y z\n");
  std::size_t id = 0;
  for (const LammpsAtom& atom : model.atoms) {
    text.line(++id, model.typeOf(atom), 2.0 * atom.radius, atom.density, vectorText(atom.position));
  }
  text.line("\nVelocities\n");
  id = 0;
  for (const LammpsAtom& atom : model.atoms) {
    text.line(++id, vectorText(atom.velocity), vectorText(atom.angularVelocity));
  }
  if (model.rigidBodies.empty()) return text.str();
  text.line("\nMolecules\n");
  id = 0;
  for (const LammpsAtom& atom : model.atoms) text.line(++id, atom.molecule);
  return text.str();
}

/// id mass, centre, inertia about world axes (xx yy zz xy xz yz), velocity, angular momentum, image.
/// firstKick: m/s, what gravity gives in the first half step, which fix rigid/small forgets at the start of a
/// run (seen in the program of 29 Sep 2021).
std::string rigidFile(const LammpsModel& model, const Vector3& firstKick) {
  Text text;
  text.line(model.rigidBodies.size());
  std::size_t id = 0;
  for (const LammpsRigidBody& body : model.rigidBodies) {
    const Matrix3 axes = body.motion.pose.orientation.toRotationMatrix();
    const Matrix3 inertia = axes * body.inertia.asDiagonal() * axes.transpose();
    text.line(++id, body.mass, vectorText(body.motion.pose.position), vectorText(inertia.diagonal()),
              inertia(0, 1), inertia(0, 2), inertia(1, 2), vectorText(body.motion.velocity + firstKick),
              vectorText(inertia * body.motion.angularVelocity), "0 0 0");
  }
  return text.str();
}

/// The input script, section by section.
class Script {
 public:
  Script(const LammpsModel& model, const LammpsDef& def, const Vector3& gravity)
      : model_(model), def_(def), gravity_(gravity) {}

  std::string text() {
    setUp();
    addGroups();
    addPairs();
    addNeighbours();
    addMotion();
    for (const LammpsWall& wall : model_.walls) addWall(wall);
    addRigid();
    addRun();
    return text_.str();
  }

 private:
  bool hasRigid() const { return !model_.rigidBodies.empty(); }
  bool hasSingle() const {
    return std::any_of(model_.atoms.begin(), model_.atoms.end(), [&](const LammpsAtom& atom) {
      return atom.molecule == 0 && model_.families[atom.family].role != LammpsRole::FixedBody;
    });
  }
  std::string typesOf(bool fixed) const {
    std::string types;
    for (const LammpsFamily& family : model_.families) {
      if ((family.role == LammpsRole::FixedBody) != fixed) continue;
      for (int t = 0; t < family.typeCount; ++t)
        types.append(" ").append(std::to_string(family.firstType + t));
    }
    return types;
  }
  bool hasFrozen() const { return !typesOf(true).empty(); }

  void setUp();
  void addGroups();
  void addPairs();
  void addNeighbours();
  void addMotion();
  void addRigid();
  void addMover(const LammpsMover& mover);
  void addWall(const LammpsWall& wall);
  void addRun();
  std::string wallStyle(const LammpsWall& wall);
  std::string groupOfTypes(const std::vector<int>& types);

  const LammpsModel& model_;
  const LammpsDef& def_;
  Vector3 gravity_;
  Text text_;
  std::map<std::vector<int>, std::string> groups_;
  std::size_t walls_ = 0, movers_ = 0, regions_ = 0;
};

void Script::setUp() {
  text_.line(
      "# Grains and covered bodies under the laws of the granular module; run it with: lmp -in in.granular");
  text_.line("units si\natom_style sphere\natom_modify map array\nnewton off\nboundary m m m");
  double reach = 0.0;
  for (const LammpsRigidBody& body : model_.rigidBodies) reach = std::max(reach, body.reach);
  double largest = 0.0;
  for (const LammpsAtom& atom : model_.atoms) largest = std::max(largest, atom.radius);
  // Ghosts must reach as far as contacts do, and as the farthest particle of a body.
  if (hasRigid()) {
    text_.line("comm_modify vel yes cutoff", 2.0 * std::max(reach, largest) + def_.skin);
    text_.line("fix molecules all property/atom mol ghost yes");
    text_.line("read_data particles.data fix molecules NULL Molecules");
  } else {
    text_.line("comm_modify vel yes\nread_data particles.data");
  }
}

void Script::addGroups() {
  if (hasFrozen()) text_.line("group frozen type" + typesOf(true));
  text_.line("group mobile type" + typesOf(false));
  if (hasRigid()) {
    text_.line("group clumps molecule > 0\ngroup single subtract mobile clumps");
  } else {
    text_.line("group single union mobile");
  }
}

void Script::addPairs() {
  if (def_.style == LammpsStyle::HertzHistory) {
    const auto contact = model_.contact(1, 1);
    text_.line("pair_style gran/hertz/history", contact->hertzHistoryText()).line("pair_coeff * *");
    return;
  }
  text_.line("pair_style granular");
  for (int a = 1; a <= model_.typeCount(); ++a) {
    for (int b = a; b <= model_.typeCount(); ++b) {
      const auto contact = model_.contact(a, b);
      text_.line("pair_coeff", a, b, contact ? contact->text() : kUnmet);
    }
  }
}

void Script::addNeighbours() {
  const auto [small, large] =
      std::minmax_element(model_.atoms.begin(), model_.atoms.end(),
                          [](const LammpsAtom& a, const LammpsAtom& b) { return a.radius < b.radius; });
  const bool isEven = large->radius <= kLargestEvenRatio * small->radius;
  text_.line("neighbor", def_.skin, isEven ? "bin" : "multi").line("neigh_modify every 1 delay 0 check yes");
  if (hasRigid()) text_.line("neigh_modify exclude molecule/intra clumps");
  if (hasFrozen()) text_.line("neigh_modify exclude group frozen frozen");
  for (int a = 1; a <= model_.typeCount(); ++a) {
    for (int b = a; b <= model_.typeCount(); ++b) {
      const bool bothFixed = model_.familyOf(a).role == LammpsRole::FixedBody &&
                             model_.familyOf(b).role == LammpsRole::FixedBody;
      if (!bothFixed && !model_.contact(a, b)) text_.line("neigh_modify exclude type", a, b);
    }
  }
}

void Script::addMotion() {
  text_.line("timestep", def_.timeStep);
  // Rigid bodies feel it at their centre: the sum over overlapping particles would be another mass.
  if (gravity_ != Vector3::Zero())
    text_.line("fix gravity single gravity", gravity_.norm(), "vector", vectorText(gravity_));
  if (hasSingle()) text_.line("fix motion single nve/sphere");
  for (std::size_t i = 0; i < std::min(kMostMovers, model_.movers.size()); ++i) addMover(model_.movers[i]);
  if (hasFrozen()) text_.line("fix held frozen freeze");
}

/// After everything that pushes: the forces of the first half step are summed in the order of the fixes.
void Script::addRigid() {
  if (!hasRigid()) return;
  text_.line("fix rigid clumps rigid/small molecule infile bodies.rigid",
             gravity_ == Vector3::Zero() ? "" : "gravity gravity");
}

/// fix move goes straight or turns, not both: then it goes straight (noteMovers tells).
void Script::addMover(const LammpsMover& mover) {
  const std::string name = numbered("mover", ++movers_);
  text_.line("group", name, "id", std::to_string(mover.first) + ":" + std::to_string(mover.last));
  const RigidMotion& m = mover.motion;
  if (m.velocity != Vector3::Zero()) {
    text_.line("fix", name, name, "move linear", vectorText(m.velocity));
  } else {
    text_.line("fix", name, name, "move rotate", vectorText(m.pose.position), vectorText(m.angularVelocity),
               2.0 * EIGEN_PI / m.angularVelocity.norm());
  }
}

std::string Script::groupOfTypes(const std::vector<int>& types) {
  std::string& name = groups_[types];
  if (name.empty()) {
    name = numbered("touching", groups_.size());
    std::string list;
    for (const int type : types) list.append(" ").append(std::to_string(type));
    text_.line("group " + name + " type" + list);
  }
  return name;
}

std::string Script::wallStyle(const LammpsWall& wall) {
  for (int axis = 0; axis < 3; ++axis) {
    const double along = wall.normal[axis];
    if (std::abs(std::abs(along) - 1.0) > kAlongAxis) continue;
    Text text;
    const std::string name = std::string(1, "xyz"[axis]) + "plane";
    if (along > 0.0) {
      text.line("wall/gran", name, wall.point[axis], "NULL");
    } else {
      text.line("wall/gran", name, "NULL", wall.point[axis]);
    }
    return text.str();
  }
  const std::string region = numbered("wall", ++regions_);
  text_.line("region", region, "plane", vectorText(wall.point), vectorText(wall.normal), "side in");
  return "wall/gran/region region " + region + "\n";
}

void Script::addWall(const LammpsWall& wall) {
  std::map<std::string, std::vector<int>> typesOfLaw;
  for (int type = 1; type <= model_.typeCount(); ++type) {
    if (model_.familyOf(type).role == LammpsRole::FixedBody) continue;
    const auto contact = model_.wallContact(wall, type);
    if (!contact) continue;
    const bool old = def_.style == LammpsStyle::HertzHistory;
    typesOfLaw[old ? "hertz/history " + contact->hertzHistoryText() : "granular " + contact->text()]
        .push_back(type);
  }
  if (typesOfLaw.empty()) return;
  const std::string style = wallStyle(wall);
  const auto space = style.find(' ');
  for (const auto& [law, types] : typesOfLaw) {
    const std::string group = groupOfTypes(types);
    text_.line("fix", numbered("wall", ++walls_), group, style.substr(0, space), law,
               style.substr(space + 1, style.size() - space - 2));
  }
}

void Script::addRun() {
  text_.line("thermo_style custom step atoms");
  text_.line("thermo", std::max<std::int64_t>(1, def_.steps));
  if (def_.dumpEvery > 0) {
    text_.line("dump states all custom", def_.dumpEvery,
               "particles.dump id type x y z vx vy vz omegax omegay omegaz fx fy fz");
    text_.line("dump_modify states sort id format float %.17g");
  }
  text_.line("run", def_.steps);
}

void checkDef(const LammpsDef& def) {
  requireNotNegative(def.timeStep, "LammpsDef.timeStep", "s");
  require(def.steps >= 0, "LammpsDef.steps", def.steps, "steps", ">= 0");
  require(def.dumpEvery >= 0, "LammpsDef.dumpEvery", def.dumpEvery, "steps", ">= 0");
  requireNotNegative(def.skin, "LammpsDef.skin", "m");
  require(def.largestTypeCount >= 1 && def.largestTypeCount <= kMostTypes, "LammpsDef.largestTypeCount",
          def.largestTypeCount, "types", "in [1, 24]");
}

/// Of the old style: one set of coefficients for every pair. Returns how far off that is.
double checkOldStyle(const LammpsModel& model) {
  double worst = model.coefficientError;
  const auto check = [](const LammpsContact& contact) {
    require(contact.isHertzHistory(), "LammpsDef.style", "HertzHistory", "",
            "Granular, unless all laws are Hertz with viscoelastic damping, under eq. 19 without a dashpot");
  };
  const auto common = model.contact(1, 1);
  for (int a = 1; a <= model.typeCount(); ++a) {
    for (int b = a; b <= model.typeCount(); ++b) {
      const auto contact = model.contact(a, b);
      if (!contact || !common) continue;
      check(*contact);
      worst = std::max(worst, difference(*contact, *common));
    }
    for (const LammpsWall& wall : model.walls) {
      if (const auto contact = model.wallContact(wall, a)) check(*contact);
    }
  }
  return worst;
}

void noteMovers(const std::vector<LammpsMover>& movers, std::vector<std::string>& notes) {
  if (movers.size() > kMostMovers) notes.push_back("kinematic bodies stand still, but for the first three");
  for (const LammpsMover& mover : movers) {
    if (mover.motion.velocity == Vector3::Zero() || mover.motion.angularVelocity == Vector3::Zero()) continue;
    notes.push_back("kinematic bodies that move and turn only move");
    return;
  }
}

double timeStepOf(const LammpsModel& model) {
  return model.shortestContactTime / kStepsPerContact;
}

}  // namespace

double lammpsTimeStep(const GranularSystem& system) {
  return timeStepOf(LammpsModel(system, 1));
}

LammpsReport writeLammps(const GranularSystem& system, const std::filesystem::path& folder,
                         const LammpsDef& given) {
  checkDef(given);
  LammpsDef def = given;
  const bool isOld = def.style == LammpsStyle::HertzHistory;
  const LammpsModel model(system, isOld ? 1 : def.largestTypeCount);
  const auto count = [&](bool fixed) {
    return std::count_if(model.atoms.begin(), model.atoms.end(), [&](const LammpsAtom& atom) {
      return (model.families[atom.family].role == LammpsRole::FixedBody) == fixed;
    });
  };
  require(count(false) > 0, "GranularSystem", 0, "moving particles", "one with something that moves");
  require(model.typeCount() <= kMostTypes, "GranularSystem", model.typeCount(), "pairs of material and role",
          "one with at most 24");
  if (def.timeStep == 0.0) def.timeStep = timeStepOf(model);
  double smallest = model.atoms.front().radius;
  for (const LammpsAtom& atom : model.atoms) smallest = std::min(smallest, atom.radius);
  if (def.skin == 0.0) def.skin = kSkinPerRadius * smallest;

  LammpsReport report;
  report.notes = model.notes;
  noteMovers(model.movers, report.notes);
  report.atoms = static_cast<std::int64_t>(model.atoms.size());
  report.rigidBodies = static_cast<std::int64_t>(model.rigidBodies.size());
  report.frozenAtoms = count(true);
  report.walls = static_cast<std::int64_t>(model.walls.size());
  report.types = model.typeCount();
  report.timeStep = def.timeStep;
  report.coefficientError = isOld ? checkOldStyle(model) : model.coefficientError;

  std::filesystem::create_directories(folder);
  report.files.push_back(write(folder / "in.granular", Script(model, def, system.gravity()).text()));
  report.files.push_back(write(folder / "particles.data", dataFile(model)));
  if (!model.rigidBodies.empty())
    report.files.push_back(
        write(folder / "bodies.rigid", rigidFile(model, 0.5 * def.timeStep * system.gravity())));
  return report;
}

}  // namespace granular
