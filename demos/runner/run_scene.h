// SPDX-License-Identifier: MIT
// Runs a scene: frames, checks after each, files beside it. Prints nothing.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "demos/runner/energy_balance.h"
#include "demos/runner/energy_check.h"
#include "demos/runner/place_checks.h"
#include "demos/runner/run_totals.h"

namespace granular_demo {

/// How far a run is.
struct RunProgress {
  int frame = 0;      ///< frames done
  int frames = 0;     ///< frames wanted
  double time = 0.0;  ///< s simulated
  std::int64_t contacts = 0;
  RunTotals work;            ///< of the frame
  double stepSeconds = 0.0;  ///< wall time of the frame's steps
};

/// What came of a bound that the scene puts on a meter.
struct ExpectedResult {
  ExpectedPart part;
  double measured = 0.0;
  bool known = false;  ///< the meter had that value
  bool holds() const {
    return known && (!part.atLeast || measured >= *part.atLeast) &&
           (!part.atMost || measured <= *part.atMost);
  }
};

/// The results of a meter.
struct MeterResult {
  std::string name;
  std::vector<std::pair<std::string, double>> values;
};

struct RunOptions {
  std::filesystem::path folder = {};         ///< for all files; empty: none are written, no pictures are made
  std::optional<int> frames = std::nullopt;  ///< > 0, from the scene's start; none: as many as it lasts
  const SavedState* state = nullptr;         ///< to begin with; none: the scene's own start
  int threads = 1;                           ///< > 0, of the simulation and of the pictures
  std::function<void(const BuiltScene&)> onBuilt = {};   ///< before the first tick; may be empty
  std::function<void(const RunProgress&)> onFrame = {};  ///< after each frame; may be empty
  std::function<bool()> shallStop = {};                  ///< asked after each tick; may be empty
};

/// Where an energy went.
struct RunState {
  granular::StepReport start;  ///< state before the first tick
  granular::StepReport end;    ///< state after the last one
};

struct RunResult {
  bool interrupted = false;
  int frames = 0;  ///< done, the started one included if it was interrupted
  int framesWanted = 0;
  int firstFrame = 0;  ///< where a resumed run began
  RunState state;
  RunTotals totals;
  EnergyCheck energy;
  EnergyBalance balance;
  std::vector<MeterResult> meters;
  std::vector<ExpectedResult> expected;  ///< empty unless the run reached the scene's end
  PlaceCounts worst;                     ///< the largest count of any frame, each on its own
  std::uint64_t stateHash = 0;
  double setUpSeconds = 0.0;    ///< wall time: of building the scene,
  double stepSeconds = 0.0;     ///< of stepping,
  double pictureSeconds = 0.0;  ///< of pictures and films,
  double totalSeconds = 0.0;    ///< of all
  std::int64_t grains = 0;
  std::int64_t grainParticles = 0;
  std::vector<std::filesystem::path> outputs;  ///< files and folders written
  std::string filmProblem;  ///< why there is no film, in one line; empty: nothing went wrong

  /// Nothing is where it must not be, no energy came from nowhere (0.1 % of the fall) and none is missing (1
  /// % of what was put in), and what the scene expects holds.
  bool passed(bool containerIsClosed) const;
};

/// What a run needs to know of its scene for the report, beside the result.
struct FinishedRun {
  std::unique_ptr<BuiltScene> scene;
  RunResult result;
};

/// Throws what building the scene throws, SceneError if bodies hold particles of others at the start, and
/// std::runtime_error if a file cannot be written.
FinishedRun runScene(SceneDef def, const RunOptions& options);

}  // namespace granular_demo
