// SPDX-License-Identifier: MIT
// What a user says about sleep. A grain or body falls asleep when the forces on it have balanced for a while,
// and wakes when they no longer do. Asleep it stands still, costs nothing, and what touches it meets it as it
// meets a static body, but for the mass that contact laws know.
//
// Balance, not slowness, is the test: at the top of its flight a grain is slow, but nothing carries it.
#pragma once

namespace granular {

struct SleepDef {
  /// Whether anything falls asleep. Off by default: a pile under a law without static friction (Bell 2005,
  /// eqs. 16 and 18) creeps for ever and would be stopped where its creep is slower than restWay/restTime.
  bool enabled = false;

  /// How long everything below has to hold before something falls asleep, s, > 0. It is looked at eight times
  /// in that time. Normal range 0.05 ... 1: at least a few swings of whatever may still rock.
  double restTime = 0.1;

  /// Farthest that any point of it may move within restTime, in smallest radii, > 0. Also bounds the kinetic
  /// energy that is lost by falling asleep. Too large stops what rolls or creeps slowly.
  double restWay = 1e-3;

  /// Largest net force, as a fraction of what it carries (the sum of the sizes of all contact forces on it),
  /// and largest net torque as that fraction of what it carries times its reach, > 0.
  double balance = 5e-4;

  /// Net force or torque, as the same fraction, beyond which a sleeper wakes, >= balance: its mean over the
  /// last restTime, what is longer ago fading by exp(-t/restTime). Each sleeper may hold up to this much
  /// without passing it on: the floor under a pile may feel that much less or more. As a mean, it lets the
  /// short waves of an impact go by, which would press everything in a bed and move nothing.
  double wakeImbalance = 2e-3;
};

}  // namespace granular
