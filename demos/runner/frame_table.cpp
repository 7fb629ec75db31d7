// SPDX-License-Identifier: MIT
#include "demos/runner/frame_table.h"

#include <algorithm>
#include <stdexcept>

namespace granular_demo {

FrameTable::FrameTable(const std::filesystem::path& file, const std::vector<std::string>& meterColumns)
    : names_(columns(meterColumns)), csv_(file, names_) {}

std::vector<std::string> FrameTable::columns(const std::vector<std::string>& meterColumns) {
  std::vector<std::string> names = {"frame",
                                    "time",
                                    "grains",
                                    "contacts",
                                    "awakeGrains",
                                    "awakeBodies",
                                    "meanOverlap",
                                    "largestOverlap",
                                    "kineticEnergy",
                                    "gravityEnergy",
                                    "elasticEnergy",
                                    "workByMovedBodies",
                                    "workByLoads",
                                    "workByJoints",
                                    "emittedEnergy",
                                    "dissipated",
                                    "energyPutIn",
                                    "balanceError",
                                    "momentumX",
                                    "momentumY",
                                    "momentumZ",
                                    "angularMomentumX",
                                    "angularMomentumY",
                                    "angularMomentumZ",
                                    "subSteps",
                                    "rejectedTrials",
                                    "evaluations",
                                    "listRebuilds",
                                    "shortestSubStep",
                                    "brokenJoints",
                                    "insideBodies",
                                    "belowGround",
                                    "outside",
                                    "notFinite",
                                    "quarantined",
                                    "stepSeconds",
                                    "pictureSeconds"};
  for (int i = 0; i < granular::kStageCount; ++i) {
    names.push_back(std::string(granular::stageName(static_cast<granular::Stage>(i))) + "Seconds");
  }
  names.insert(names.end(), meterColumns.begin(), meterColumns.end());
  return names;
}

void FrameTable::add(const FrameRecord& record, const BuiltScene& scene, const EnergyBalance& balance) {
  const auto number = [](auto count) { return static_cast<double>(count); };
  const granular::StepReport& state = record.state;
  const RunTotals& work = record.work;
  const PlaceCounts& places = record.places;
  std::vector<double> row = {number(record.frame),
                             scene.time(),
                             number(scene.grains().grainCount()),
                             number(state.contacts),
                             number(state.awakeGrains),
                             number(state.awakeBodies),
                             state.meanOverlap,
                             work.largestOverlap,
                             state.energy.kinetic,
                             state.energy.potential,
                             state.energy.elastic,
                             state.workByMovedBodies,
                             state.workByLoads,
                             scene.outsideEnergy().byConstraints,
                             scene.outsideEnergy().emitted,
                             state.dissipated,
                             balance.putIn(),
                             balance.error(),
                             state.momentum.x(),
                             state.momentum.y(),
                             state.momentum.z(),
                             state.angularMomentum.x(),
                             state.angularMomentum.y(),
                             state.angularMomentum.z(),
                             number(work.subSteps),
                             number(work.rejectedTrials),
                             number(work.evaluations),
                             number(work.listRebuilds),
                             work.shortestSubStep,
                             number(scene.joints().broken()),
                             number(places.insideBodies),
                             number(places.belowGround),
                             number(places.outside),
                             number(places.notFinite),
                             number(work.quarantined),
                             record.stepSeconds,
                             record.pictureSeconds};
  row.insert(row.end(), work.stageSeconds.begin(), work.stageSeconds.end());
  row.insert(row.end(), record.meters.begin(), record.meters.end());
  csv_.row(row);
  rows_.push_back(std::move(row));
}

std::vector<double> FrameTable::column(const std::string& name) const {
  const auto found = std::find(names_.begin(), names_.end(), name);
  if (found == names_.end()) throw std::out_of_range("no column is named " + name);
  std::vector<double> numbers;
  for (const std::vector<double>& row : rows_)
    numbers.push_back(row[static_cast<std::size_t>(found - names_.begin())]);
  return numbers;
}

}  // namespace granular_demo
