// SPDX-License-Identifier: MIT
#include "demos/runner/frame_table.h"

namespace granular_demo {

FrameTable::FrameTable(const std::filesystem::path& file) : csv_(file, columns()) {}

std::vector<std::string> FrameTable::columns() {
  std::vector<std::string> names = {"frame",
                                    "time",
                                    "contacts",
                                    "meanOverlap",
                                    "largestOverlap",
                                    "kineticEnergy",
                                    "gravityEnergy",
                                    "elasticEnergy",
                                    "workByMovedBodies",
                                    "workByLoads",
                                    "dissipated",
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
  return names;
}

void FrameTable::add(int frame, const granular::StepReport& state, const RunTotals& work,
                     const PlaceCounts& places, double stepSeconds, double pictureSeconds) {
  const auto number = [](std::int64_t count) { return static_cast<double>(count); };
  std::vector<double> row = {static_cast<double>(frame),
                             state.time,
                             number(state.contacts),
                             state.meanOverlap,
                             work.largestOverlap,
                             state.energy.kinetic,
                             state.energy.potential,
                             state.energy.elastic,
                             state.workByMovedBodies,
                             state.workByLoads,
                             state.dissipated,
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
                             number(places.insideBodies),
                             number(places.belowGround),
                             number(places.outside),
                             number(places.notFinite),
                             number(work.quarantined),
                             stepSeconds,
                             pictureSeconds};
  row.insert(row.end(), work.stageSeconds.begin(), work.stageSeconds.end());
  csv_.row(row);
}

}  // namespace granular_demo
