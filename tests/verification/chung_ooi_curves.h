// SPDX-License-Identifier: MIT
// The eight tests of Chung & Ooi 2011 (Granular Matter 13:643) of a DEM code at the level of one impact:
// set-ups, materials, and the curves of tests 1 to 6 for the figures.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tests/verification/impact.h"

namespace granular::verification {

struct ChungOoiMaterial {
  const char* name;
  double youngsModulus;  ///< Pa
  double poissonRatio;
  double density;  ///< kg/m^3
};

/// Materials of test 1 ... 8, in the order of the paper.
const std::vector<ChungOoiMaterial>& chungOoiMaterials(int test);

/// A ball of the material.
Ball ballOf(const ChungOoiMaterial& material, double radius);

/// Test 4, 5 or 6 against the rigid plane under one shear law: tangential speed (m/s) at the centre and spin
/// (rad/s) about -z, so that both carry the contact point the same way. Restitution by Tsuji's law: the same
/// at every speed.
struct ObliqueSetUp {
  int test = 4;
  ChungOoiMaterial material = {};
  double radius = 0.0;  ///< m
  double restitution = 1.0;
  double friction = 0.0;
  double normalSpeed = 0.0, tangentialSpeed = 0.0, spin = 0.0;
};
std::vector<ObliqueSetUp> obliqueSetUps(int test, const ChungOoiMaterial& material);

ImpactDef impactOf(const ObliqueSetUp& setUp, ShearLaw law);

/// Normal and tangential speed and spin after an impact, signs as in ObliqueSetUp.
struct ObliqueRebound {
  double normalSpeed = 0.0, tangentialSpeed = 0.0, spin = 0.0;
};
ObliqueRebound measureOblique(const ImpactDef& def);
/// The same under law 19 (Bell 2005, eq. 19), integrated independently of the system.
ObliqueRebound referenceOblique(const ObliqueSetUp& setUp);
/// The same if the contact slides throughout: exact for Coulomb friction, the arm taken to the plane.
ObliqueRebound slidingOblique(const ObliqueSetUp& setUp);
/// Whether it slides throughout for sure: surface speed > 3.5 mu (1 + e) v_n, with 5 % to spare.
bool slidesThroughout(const ObliqueSetUp& setUp);

/// A curve of a figure.
enum class CurveKind { Measured, Expected, Published };
struct Curve {
  std::string name;
  CurveKind kind = CurveKind::Measured;
  std::vector<double> x, y;
};
struct CurveFigure {
  std::string title, xLabel, yLabel;
  std::vector<Curve> curves = {};
  std::optional<double> yLow = {}, yHigh = {};  ///< ends of the axes, to leave room for the legend
};
/// Tests 1 to 6, two or three a test.
std::vector<CurveFigure> chungOoiFigures();

/// Test 1 (two equal balls) or 2 (ball on the rigid plane), set to keep its history.
ImpactDef elasticImpact(int test, const ChungOoiMaterial& material);
/// Force at the times of a history by an independent integration of Hertz's elastic impact, N.
std::vector<double> elasticForces(const ImpactDef& def, const std::vector<ImpactSample>& history);

/// Published values (Chung & Ooi 2011) that VERIFICATION quotes.
struct PublishedRange {
  double angleDegrees, low, high;
};
/// Tangential restitution of aluminium oxide in test 4.
const std::vector<PublishedRange>& publishedTangentialRestitution();

}  // namespace granular::verification
