// SPDX-License-Identifier: MIT
// The subcommands of granular_bench. Each adds itself to the command line and sets the exit status when it
// has run.
#pragma once

namespace CLI {
class App;
}

namespace granular_bench {

/// `kernel [--particles N] [--threads N]`: what an evaluation costs, stage by stage.
void addKernelCommand(CLI::App& app, int& status);

/// `cover [--only TEXT] [--long] [--threads N]`: time and quality of coverings; status 1 if one is wrong.
void addCoverCommand(CLI::App& app, int& status);

/// `peers [--lammps FILE] [--particles N] [--steps N] [--repeats N] [--only TEXT]`: ours against LAMMPS,
/// answers first; throws std::runtime_error if they differ.
void addPeersCommand(CLI::App& app, int& status);

/// `plain-world [--pairs N]`: time of a world without grains over plain Bullet's, bits compared first.
void addPlainWorldCommand(CLI::App& app, int& status);

/// `restitution [--out DIR]`: figure 3 of the paper, PNG and CSV.
void addRestitutionCommand(CLI::App& app, int& status);

/// `paper-table [--scale S] [--frames A:B] [--only SCENE] [--threads N] [--state FILE] [--csv FILE]`: the
/// five scenes beside table 1 of the paper.
void addPaperTableCommand(CLI::App& app, int& status);

/// `scaling [--most N] [--threads N] [--repeats N]`: time and memory a particle, by number and by threads.
void addScalingCommand(CLI::App& app, int& status);

/// `search [--particles N] [--steps N]`: the paper's hash, the plain one and ours; throws if they differ.
void addSearchCommand(CLI::App& app, int& status);

/// `skip [--spheres N] [--steps N] [--ground N] [--pairs N]`: what scenes pay for what they do not use; status
/// 1 if something is paid.
void addSkipCommand(CLI::App& app, int& status);

/// `stacking [--only SCENE] [--setup NAME] [--seconds T] [--full] [--out DIR]`: stacks in Bullet's solver and
/// in ours: drift, depth, time to rest, standing, cost; table, CSV, pictures.
void addStackingCommand(CLI::App& app, int& status);

/// `sleep [--across N] [--layers N] [--threads N]`: what a bed at rest costs awake and asleep, and a ball that
/// lands on it; throws std::runtime_error if floor and walls do not bear the weight.
void addSleepCommand(CLI::App& app, int& status);

/// `stress [--only TEXT] [--csv FILE] [--list]`: scenes at the limits; status 1 if one is not as expected.
void addStressCommand(CLI::App& app, int& status);

/// `surfaces [--grains N] [--csv FILE]`: grains on particles, on exact boxes and on distance fields: cost,
/// drain rate, heap.
void addSurfacesCommand(CLI::App& app, int& status);

/// `verify [--only TEXT] [--long] [--list] [--csv FILE] [--plots DIR]`: the table of all cases with known
/// answers; status 1 if one fails.
void addVerifyCommand(CLI::App& app, int& status);

/// `work-precision [SCENE] [--spheres-per-side N] [--repeats N] [--out DIR]`: evaluations and run time
/// against true error for every stepper; status 2 if the reference does not agree with itself.
void addWorkPrecisionCommand(CLI::App& app, int& status);

}  // namespace granular_bench
