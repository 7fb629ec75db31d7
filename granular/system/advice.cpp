// SPDX-License-Identifier: MIT
// Advice on what is legal but unwise. Each estimate is one line of textbook physics on the constants that the
// contact laws would really use, for the kinds of particles that are in the system now; nothing is simulated.
//
// Sub-steps. A damper c on a mass m decays at c/m, and the stability polynomial of RKF45,
// 1 + z + z^2/2 + z^3/6 + z^4/24 + z^5/104, leaves [-1, 1] at z = -3.0: it asks for sub-steps of 3 m/c. Law
// 16 gets just these (measured: 1.0e-5 s at 0.9e-5 s asked for). Law 18 is bounded by mu fn, so that a loose
// tolerance steps over it: its friction then chatters instead of creeping. A spring k swings at sqrt(k/m);
// error control resolves about one radian of it. Along a contact the mass is 2/7 of m_eff, as between solid
// spheres.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <tuple>

#include "granular/base/require.h"
#include "granular/contact/law_list.h"
#include "granular/system/detail/system_impl.h"

namespace granular {
namespace {

constexpr double kDeepOverlap = 0.05;     // of the smaller radius; beyond it round particles turn soft
constexpr double kFastCreep = 1e-3;       // m/s: a centimetre in ten seconds shows
constexpr double kLowRestitution = 0.05;  // below it dampers outrun the contact time
constexpr double kDecayPerSubStep = 3.0;  // see above
constexpr double kTangentialMass = 2.0 / 7.0;
constexpr std::size_t kKindsTakenAsTheyAre = 64;  // more of them: only the extremes of each material

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

/// A kind of particle or exact surface, and whose it is.
struct Side {
  detail::ParticleKind kind;
  std::int32_t owner = -1;  ///< the first one that has it
  bool hasMoreOwners = false;
  bool isSurface = false;

  bool canMeet(const Side& other) const {
    return kind.inverseMass + other.kind.inverseMass > 0.0 &&
           kind.inverseRadius + other.kind.inverseRadius > 0.0 && !(isSurface && other.isSurface) &&
           (hasMoreOwners || other.hasMoreOwners || owner != other.owner);
  }
};

std::vector<Side> sidesOf(const detail::Layout& layout) {
  std::vector<Side> sides;
  std::map<detail::ParticleKind, std::size_t> known;
  layout.forEachKind([&](const detail::ParticleKind& kind, std::int32_t owner, bool isSurface) {
    const auto [found, isNew] = known.try_emplace(kind, sides.size());
    if (isNew) sides.push_back({.kind = kind, .owner = owner});
    Side& side = sides[found->second];
    side.hasMoreOwners |= side.owner != owner;
    side.isSurface = isSurface;
  });
  return sides;
}

/// Grains of every size make a kind each. Of many kinds only the lightest, heaviest, smallest and largest of
/// each material are looked at: estimates grow or fall steadily with mass and radius.
std::vector<Side> extremesOf(std::vector<Side> sides) {
  if (sides.size() <= kKindsTakenAsTheyAre) return sides;
  using Group = std::tuple<std::int32_t, bool, bool>;
  std::map<Group, std::vector<Side>> groups;
  for (const Side& s : sides) groups[{s.kind.material, s.kind.isBody, s.kind.inverseMass > 0.0}].push_back(s);
  std::vector<Side> chosen;
  for (const auto& group : groups) {
    const std::vector<Side>& members = group.second;
    const auto take = [&](auto measure) {
      const auto [low, high] = std::minmax_element(
          members.begin(), members.end(),
          [&](const Side& a, const Side& b) { return measure(a.kind) < measure(b.kind); });
      for (Side side : {*low, *high}) {
        side.hasMoreOwners |= members.size() > 1;  // others of about its size
        chosen.push_back(side);
      }
    };
    take([](const detail::ParticleKind& k) { return k.inverseMass; });
    take([](const detail::ParticleKind& k) { return k.inverseRadius; });
  }
  return chosen;
}

/// The lines found so far: of each topic only the worst of every two materials.
class Advice {
 public:
  enum class Topic { Restitution, Overlap, NormalDamping, ShearViscosity, ShearStiffness, Creep };

  template <class Text>
  void add(Topic topic, std::pair<std::int32_t, std::int32_t> materials, double badness, const Text& text) {
    const auto [found, isNew] = worst_.try_emplace({topic, materials}, 0.0, std::string());
    if (!isNew && found->second.first >= badness) return;
    found->second = {badness, text()};
  }

  std::vector<std::string> lines() const {
    std::vector<std::string> all;
    for (const auto& [key, value] : worst_) all.push_back(value.second);
    return all;
  }

 private:
  std::map<std::pair<Topic, std::pair<std::int32_t, std::int32_t>>, std::pair<double, std::string>> worst_;
};

/// Two kinds that may meet, with the law between them.
class Meeting {
 public:
  Meeting(const Side& a, const Side& b, const std::vector<MaterialDef>& materials, const MaterialPair& pair,
          double speed, const IntegratorDef& integrator)
      : a_(a.kind), b_(b.kind), materials_(materials), pair_(pair), speed_(speed), integrator_(integrator) {
    law_ = makePairLaw(pair, detail::sideOf(a_, materials[a_.material]),
                       detail::sideOf(b_, materials[b_.material]));
    mass_ = 1.0 / (a_.inverseMass + b_.inverseMass);
    radius_ = 1.0 / std::max(a_.inverseRadius, b_.inverseRadius);
    withNormalLaw(law_.normalLaw, [&]<class Law>(Law) {
      depth_ = depthOf<Law>();
      const double spring = law_.normal.kr, inverseMass = law_.normal.stiffnessPerMass / spring;
      // Dampers are linear in the overlap rate. Laws by area: all of the body over all of its mass.
      decay_ = (Law::force(law_.normal, depth_, 1.0) - Law::force(law_.normal, depth_, 0.0)) * inverseMass;
      allowed_ = integrator.contactTimeFraction * contactTimeOfUrgency(Law::urgency(law_.normal, 0.0, speed));
    });
  }

  void adviseOn(Advice& advice) const {
    checkRestitution(advice);
    if (speed_ > 0.0) {
      checkOverlap(advice);
      checkDamping(advice);
      checkShear(advice);
    }
  }

  /// Speed at which law 18 lets a grain of side A sink along one contact with B, m/s.
  double creepSpeed(double gravity) const {
    const bool isHeldByLaw18 =
        !a_.isBody && law_.shearLaw == ShearLaw::RegularisedCoulomb && pair_.friction > 0.0;
    return isHeldByLaw18 ? gravity / (a_.inverseMass * law_.shear.viscosity) : 0.0;
  }
  std::string creepText(double gravity) const {
    const double enough = gravity / (a_.inverseMass * kFastCreep);
    return "law 18 has no static friction: a grain of " + nameOf(a_) + " held by one contact on " +
           nameOf(b_) + " creeps at " + number(creepSpeed(gravity)) +
           " m/s (m g / kt); shear.law static-friction holds it, "
           "shear.viscosity " +
           number(enough) + " N s/m slows it to " + number(kFastCreep) + " m/s at sub-steps of " +
           number(kDecayPerSubStep * tangentialMass() / enough) + " s";
  }

 private:
  using Topic = Advice::Topic;

  const std::string& nameOf(const detail::ParticleKind& kind) const { return materials_[kind.material].name; }
  std::string names() const { return nameOf(a_) + " on " + nameOf(b_) + ": "; }
  std::pair<std::int32_t, std::int32_t> key() const { return std::minmax(a_.material, b_.material); }
  bool ofBodies() const { return a_.isBody && b_.isBody; }
  const NormalLawDef& normalDef() const { return ofBodies() ? pair_.def.bodyNormal : pair_.def.normal; }
  std::string normalField(const char* name) const {
    return std::string(ofBodies() ? "bodyNormal." : "normal.") + name;
  }
  double tangentialMass() const { return kTangentialMass * mass_; }

  /// Deepest overlap of an impact without losses, m: where the spring's energy is that of the impact. Of a
  /// body under a law by area, if all of one side of it touches at once: the least there can be.
  template <class Law>
  double depthOf() const {
    const double k = law_.normal.stiffnessPerMass;
    if constexpr (Law::kByArea) return speed_ / std::sqrt(0.5 * k);
    if constexpr (Law::kStiffnessPower == 0.0) return speed_ / std::sqrt(k);
    return std::pow(1.25 * speed_ * speed_ / k, 0.4);
  }

  void checkRestitution(Advice& advice) const {
    if (pair_.restitution >= kLowRestitution || normalDef().damping) return;
    advice.add(Topic::Restitution, key(), 1.0 - pair_.restitution, [&] {
      return names() + "restitution is " + number(pair_.restitution) +
             ": below 0.05 the damper outruns the contact and costs sub-steps for a rebound that nobody "
             "sees; "
             "0.05 is enough";
    });
  }

  void checkOverlap(Advice& advice) const {
    const double share = depth_ / radius_;
    if (share <= kDeepOverlap) return;
    advice.add(Topic::Overlap, key(), share, [&] {
      const bool byArea = law_.normalLaw == NormalLaw::ElasticFoundation;
      return names() + "impacts at " + number(speed_) + " m/s overlap by " +
             (byArea ? "at least " : "up to ") + number(100.0 * share) + " % of the smaller radius (" +
             number(radius_) + " m); " + remedy(share / kDeepOverlap);
    });
  }

  /// What makes the overlap `factor` times smaller.
  std::string remedy(double factor) const {
    // Depth ~ stiffness^-(2/5) under Hertz laws, ~ stiffness^-(1/2) under the others. Where elasticity only
    // sets the contact time of a linear spring, that is a Hertz one.
    const bool isHertz =
        law_.normalLaw != NormalLaw::LinearSpring && law_.normalLaw != NormalLaw::ElasticFoundation;
    const double stiffer = std::pow(factor, isHertz ? 2.5 : 2.0);
    const NormalLawDef& def = normalDef();
    if (def.contactTime) {
      return normalField("contactTime") + " " + number(*def.contactTime / factor) + " s in place of " +
             number(*def.contactTime) + " s gives 5 %";
    }
    if (def.stiffness) {
      return normalField("stiffness") + " " + number(*def.stiffness * stiffer) + " in place of " +
             number(*def.stiffness) + " gives 5 %";
    }
    const double times = std::pow(factor, law_.normalLaw == NormalLaw::ElasticFoundation ? 2.0 : 2.5);
    const auto modulus = [&](const detail::ParticleKind& kind) {
      const double now = materials_[kind.material].youngsModulus;
      return "youngsModulus of " + nameOf(kind) + " " + number(now * times) + " Pa in place of " +
             number(now) + " Pa";
    };
    if (a_.material == b_.material) return modulus(a_) + " gives 5 %";
    return modulus(a_) + " and " + modulus(b_) + " give 5 %";
  }

  void checkDamping(Advice& advice) const {
    if (!normalDef().damping) return;
    const double forced = kDecayPerSubStep / decay_;
    addSubStep(advice, Topic::NormalDamping, normalField("damping"), *normalDef().damping, "", forced,
               *normalDef().damping * forced / allowed_);
  }

  void checkShear(Advice& advice) const {
    const ShearLawDef& def = pair_.def.shear;
    if (pair_.friction == 0.0 && def.law != ShearLaw::Viscous) return;
    if (def.viscosity) {
      addSubStep(advice, Topic::ShearViscosity, "shear.viscosity", *def.viscosity, " N s/m",
                 kDecayPerSubStep * tangentialMass() / *def.viscosity,
                 kDecayPerSubStep * tangentialMass() / allowed_);
    }
    if (def.stiffness) {
      addSubStep(advice, Topic::ShearStiffness, "shear.stiffness", *def.stiffness, " N/m",
                 std::sqrt(tangentialMass() / *def.stiffness), tangentialMass() / (allowed_ * allowed_));
    }
  }

  void addSubStep(Advice& advice, Topic topic, const std::string& field, double value, const char* unit,
                  double forced, double enough) const {
    if (!(forced < allowed_)) return;
    advice.add(topic, key(), allowed_ / forced, [&] {
      std::string text = names() + field + " is " + number(value) + unit + ", which asks for sub-steps of " +
                         number(forced) + " s where the contact time does for " + number(allowed_) +
                         " s; at most " + number(enough) + unit + " would not";
      if (forced < integrator_.smallestSubStep) {
        text += "; the one asked for is below smallestSubStep (" + number(integrator_.smallestSubStep) +
                " s): " +
                (law_.shearLaw == ShearLaw::Viscous || topic == Topic::NormalDamping
                     ? "the motion is unstable and what touches may be lost"
                     : "it cannot be followed");
      }
      return text;
    });
  }

  const detail::ParticleKind& a_;
  const detail::ParticleKind& b_;
  const std::vector<MaterialDef>& materials_;
  const MaterialPair& pair_;
  double speed_;
  const IntegratorDef& integrator_;
  PairLaw law_;
  double mass_ = 0.0;     ///< m_eff, kg
  double radius_ = 0.0;   ///< the smaller one, m
  double depth_ = 0.0;    ///< deepest overlap at the speed, m
  double decay_ = 0.0;    ///< of the normal damper at that depth, 1/s
  double allowed_ = 0.0;  ///< sub-step that the contact time asks for, s
};

}  // namespace

std::vector<std::string> GranularSystem::advice(double speed) {
  requireNotNegative(speed, "speed", "m/s");
  Impl& s = *impl_;
  s.prepare();
  const std::vector<MaterialPair>& pairs = s.materialPairs();
  const std::vector<Side> sides = extremesOf(sidesOf(s.evaluation.layout()));
  const double gravity = s.gravity.norm();
  Advice advice;
  double fastestCreep = kFastCreep;
  for (const Side& a : sides) {
    for (const Side& b : sides) {
      if (!a.canMeet(b)) continue;
      const MaterialPair& pair = pairs[a.kind.material * s.materials.size() + b.kind.material];
      const Meeting meeting(a, b, s.materials, pair, speed, s.integrator);
      meeting.adviseOn(advice);
      const double creep = meeting.creepSpeed(gravity);
      if (creep <= fastestCreep) continue;
      fastestCreep = creep;  // one line for all: the cure is the same
      advice.add(Advice::Topic::Creep, {}, creep, [&] { return meeting.creepText(gravity); });
    }
  }
  return advice.lines();
}

}  // namespace granular
