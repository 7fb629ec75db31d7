// SPDX-License-Identifier: MIT
#include "demos/runner/run_report.h"

#include <LinearMath/btScalar.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <map>
#include <stdexcept>
#include <thread>

#include "demos/scene/scene_file.h"

namespace granular_demo {
namespace {

Json vectorOf(const Vector3& v) {
  return {v.x(), v.y(), v.z()};
}

std::string processorName() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  }
  return "unknown";
}

Json buildInfo() {
  return {
    {"granular", GRANULAR_VERSION},
        {"bullet", std::to_string(btGetVersion() / 100) + "." + std::to_string(btGetVersion() % 100)},
        {"bulletPrecision", sizeof(btScalar) == 8 ? "double" : "float"},
#if defined(__clang__)
        {"compiler", "clang " __clang_version__},
#else
        {"compiler", "gcc " __VERSION__},
#endif
    {
      "buildType", GRANULAR_BUILD_TYPE
    }
  };
}

Json machineInfo() {
  return {{"processor", processorName()}, {"hardwareThreads", std::thread::hardware_concurrency()}};
}

Json sceneInfo(const SceneDef& def) {
  return {{"name", def.name},
          {"file", def.file.string()},
          {"scale", def.scale},
          {"seed", def.seed},
          {"duration", def.duration},
          {"frameRate", def.frameRate},
          {"ticksPerFrame", def.ticksPerFrame},
          {"stepper", stepperNames().at(static_cast<std::size_t>(def.integrator.stepper))},
          {"fixedSubStep", def.integrator.fixedSubStep},
          {"tolerance", def.integrator.tolerance},
          {"contactTimeFraction", def.integrator.contactTimeFraction},
          {"eventFraction", def.integrator.eventFraction},
          {"eventContacts", def.integrator.eventContacts},
          {"precision", precisionNames().at(static_cast<std::size_t>(def.integrator.precision))},
          {"smallestSubStep", def.integrator.smallestSubStep},
          {"trialLimit", def.integrator.trialLimit}};
}

Json coveringInfo(const BuiltScene& scene) {
  Json all = Json::array();
  for (const BuiltBody& body : scene.bodies()) {
    if (body.part->place != std::array<int, 3>{}) continue;  // copies share the covering of the first
    for (const granular::CoverReport& report : body.covering->reports) {
      all.push_back({{"body", body.part->name},
                     {"particles", report.particleCount},
                     {"particleRadius", report.particleRadius},
                     {"density", report.density},
                     {"spacingMin", report.spacingMin},
                     {"spacingMedian", report.spacingMedian},
                     {"spacingMax", report.spacingMax},
                     {"largestHole", report.largestHole},
                     {"holeBound", report.holeBound},
                     {"holesClosed", report.holesClosed},
                     {"envelopeMean", report.envelopeMean},
                     {"envelopeMax", report.envelopeMax},
                     {"iterations", report.iterations},
                     {"converged", report.converged}});
    }
  }
  return all;
}

std::int64_t dynamicBodyParticles(const BuiltScene& scene) {
  std::int64_t count = 0;
  for (const BuiltBody& body : scene.bodies()) {
    if (body.part->motion == BodyKind::dynamic)
      count += static_cast<std::int64_t>(body.covering->covering.positions.size());
  }
  return count;
}

Json countInfo(const BuiltScene& scene, const RunResult& result) {
  return {{"grains", result.grains},
          {"particles", result.grainParticles + scene.coveringParticles()},
          {"grainParticles", result.grainParticles},
          {"coveringParticles", scene.coveringParticles()},
          {"bodies", scene.bodies().size()},
          {"dynamicBodyParticles", dynamicBodyParticles(scene)}};
}

Json stepInfo(const RunResult& result) {
  const RunTotals& totals = result.totals;
  Json stages = Json::object();
  for (int i = 0; i < granular::kStageCount; ++i) {
    stages[granular::stageName(static_cast<granular::Stage>(i))] = totals.stageSeconds[i];
  }
  const double seconds = result.stepSeconds;
  const auto perSecond = [&](double count) { return seconds > 0.0 ? count / seconds : 0.0; };
  return {{"ticks", totals.ticks},
          {"subSteps", totals.subSteps},
          {"rejectedTrials", totals.rejectedTrials},
          {"evaluations", totals.evaluations},
          {"listRebuilds", totals.listRebuilds},
          {"shortestSubStep", totals.shortestSubStep},
          {"largestContacts", totals.largestContacts},
          {"evaluationsPerSecond", perSecond(static_cast<double>(totals.evaluations))},
          {"roundParticleEvaluationsPerSecond",
           perSecond(static_cast<double>(totals.evaluations) * static_cast<double>(result.grainParticles))},
          {"stageSeconds", stages},
          {"warnings", granular::describe(totals.flags)}};
}

Json energyInfo(const granular::StepReport& state) {
  return {{"kinetic", state.energy.kinetic},
          {"gravity", state.energy.potential},
          {"elastic", state.energy.elastic},
          {"total", state.energy.total()},
          {"workByMovedBodies", state.workByMovedBodies},
          {"workByLoads", state.workByLoads},
          {"dissipated", state.dissipated},
          {"momentum", vectorOf(state.momentum)},
          {"angularMomentum", vectorOf(state.angularMomentum)}};
}

Json checkInfo(const BuiltScene& scene, const RunResult& result) {
  const auto& container = scene.def().container;
  return {{"passed", result.passed(container && container->closed)},
          {"passThrough", result.worst.insideBodies},
          {"passThroughBody", result.worst.inside},
          {"belowGround", result.worst.belowGround},
          {"escaped", result.worst.outside},
          {"notFinite", result.worst.notFinite},
          {"quarantined", result.totals.quarantined},
          {"worstOverlap", result.totals.largestOverlap},
          {"worstOverlapTime", result.totals.largestOverlapTime},
          {"energyPutIn", result.balance.putIn()},
          {"balanceError", result.balance.error()},
          {"worstBalanceFraction", result.balance.worstFraction()},
          {"worstBalanceTime", result.balance.worstTime()},
          {"energyFallen", result.energy.fallen()},
          {"worstEnergyRise", result.energy.worstRise()},
          {"worstEnergyRiseFraction", result.energy.worstFraction()},
          {"worstEnergyRiseTime", result.energy.worstTime()}};
}

Json outcomeInfo(const RunResult& result) {
  Json all = Json::object();
  for (const MeterResult& meter : result.meters) {
    Json& values = all[meter.name] = Json::object();
    for (const auto& [name, value] : meter.values) values[name] = value;
  }
  return all;
}

Json expectedInfo(const RunResult& result) {
  Json all = Json::array();
  for (const ExpectedResult& expected : result.expected) {
    Json one = {{"meter", expected.part.meter}, {"value", expected.part.value}};
    if (expected.part.atLeast) one["atLeast"] = *expected.part.atLeast;
    if (expected.part.atMost) one["atMost"] = *expected.part.atMost;
    one["measured"] = expected.known ? Json(expected.measured) : Json();
    one["holds"] = expected.holds();
    all.push_back(one);
  }
  return all;
}

Json emitterInfo(const BuiltScene& scene) {
  Json all = Json::array();
  for (const BuiltEmitter& built : scene.emitters()) {
    all.push_back({{"name", built.part->name},
                   {"poured", built.emitter.poured()},
                   {"mostWaiting", built.mostWaiting},
                   {"firstWait", built.firstWait < 0.0 ? Json() : Json(built.firstWait)}});
  }
  return all;
}

/// Where a run began if not at the scene's own start.
Json beginningInfo(const RunOptions& options) {
  if (!options.state) return {};
  return {{"scene", options.state->scene},
          {"scale", options.state->scale},
          {"time", options.state->time},
          {"grains", options.state->grains.size()},
          {"bodies", options.state->bodies.size()}};
}

/// The heaviest grain of a material, on one contact of its smallest particle: the fastest creep law 18
/// implies.
Json creepInfo(const BuiltScene& scene) {
  const granular::GranularSystem& grains = scene.grains();
  struct Heaviest {
    double mass = 0.0, radius = 0.0;
  };
  std::map<std::int32_t, Heaviest> heaviest;
  for (std::int32_t i = 0; i < static_cast<std::int32_t>(grains.grainMotions().size()); ++i) {
    const granular::GrainId id = grains.grainAt(i);
    if (id.index < 0) continue;  // removed
    Heaviest& h = heaviest[grains.materialOf(id).index];
    if (grains.massOf(id) <= h.mass) continue;
    const auto& particles = grains.grainShape(grains.shapeOf(id)).particles;
    h.mass = grains.massOf(id);
    h.radius = grains.scaleOf(id) *
               std::min_element(particles.begin(), particles.end(), [](const auto& a, const auto& b) {
                 return a.radius < b.radius;
               })->radius;
  }
  Json all = Json::array();
  for (const granular::MaterialDef& a : scene.def().materials) {
    const auto grain = heaviest.find(scene.material(a.name).index);
    if (grain == heaviest.end()) continue;
    for (const granular::MaterialDef& b : scene.def().materials) {
      const double speed = grains.creepSpeed(scene.material(a.name), scene.material(b.name),
                                             grain->second.mass, grain->second.radius);
      all.push_back({{"grain", a.name}, {"on", b.name}, {"speed", speed}});
    }
  }
  return all;
}

Json adviceInfo(const BuiltScene& scene) {
  const ImpactSpeed& impact = scene.impactSpeed();
  return {{"impactSpeed", impact.speed}, {"reason", impact.reason}, {"lines", scene.advice()}};
}

Json timeInfo(const RunResult& result) {
  return {{"total", result.totalSeconds},
          {"setUp", result.setUpSeconds},
          {"steps", result.stepSeconds},
          {"pictures", result.pictureSeconds}};
}

Json outputInfo(const RunResult& result) {
  Json paths = Json::array();
  for (const std::filesystem::path& path : result.outputs) paths.push_back(path.string());
  return paths;
}

}  // namespace

Json makeReport(const FinishedRun& run, const RunOptions& options,
                const std::vector<std::string>& commandLine) {
  const RunResult& result = run.result;
  char hash[32];
  std::snprintf(hash, sizeof hash, "%016llx", static_cast<unsigned long long>(result.stateHash));
  return {{"commandLine", commandLine},
          {"result", result.interrupted ? "interrupted" : "completed"},
          {"scene", sceneInfo(run.scene->def())},
          {"build", buildInfo()},
          {"machine", machineInfo()},
          {"threads", options.threads},
          {"counts", countInfo(*run.scene, result)},
          {"coverings", coveringInfo(*run.scene)},
          {"beganWith", beginningInfo(options)},
          {"firstFrame", result.firstFrame},
          {"frames", result.frames},
          {"framesWanted", result.framesWanted},
          {"simulatedSeconds", run.scene->time()},
          {"steps", stepInfo(result)},
          {"start", energyInfo(result.state.start)},
          {"end", energyInfo(result.state.end)},
          {"outcome", outcomeInfo(result)},
          {"expected", expectedInfo(result)},
          {"emitters", emitterInfo(*run.scene)},
          {"joints", run.scene->joints().count()},
          {"brokenJoints", run.scene->joints().broken()},
          {"checks", checkInfo(*run.scene, result)},
          {"advice", adviceInfo(*run.scene)},
          {"creepSpeeds", creepInfo(*run.scene)},
          {"stateHash", hash},
          {"wallSeconds", timeInfo(result)},
          {"filmProblem", result.filmProblem},
          {"outputs", outputInfo(result)}};
}

void writeReport(const Json& report, const std::filesystem::path& file) {
  if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path());
  std::ofstream out(file);
  out << report.dump(2, ' ', false, Json::error_handler_t::replace) << std::endl;
  if (!out) throw std::runtime_error(file.string() + ": cannot be written");
}

}  // namespace granular_demo
