// SPDX-License-Identifier: MIT
// Ctrl-C (SIGINT) and SIGTERM as a wish to end after the present step. A second one ends the program at once.
#pragma once

namespace granular_demo {

void listenForStopSignals();
bool stopWasAsked();

}  // namespace granular_demo
