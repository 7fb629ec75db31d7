// SPDX-License-Identifier: MIT
// The stages of the layer at the three places of a tick where Bullet calls out (3.24): prepareSolve comes
// before the islands are solved, allSolved after, actions after bodies have moved. Multi-body worlds solve
// with their own solver, but call these two all the same.
#include "bullet_bridge/granular_layer.h"

#include <stdexcept>

#include "bullet_bridge/debug_draw.h"
#include "bullet_bridge/granular_dynamics_world.h"
#include "bullet_bridge/layer.h"

namespace bullet_bridge {
inline namespace BULLET_BRIDGE_PRECISION {
namespace detail {
namespace {

/// btDiscreteDynamicsWorld::setConstraintSolver frees the memory of a solver that the world made itself. The
/// solver must live on behind the layer, so the world is told meanwhile that it is not its own.
struct SolverOwnership : btDiscreteDynamicsWorld {
  static bool& of(btDiscreteDynamicsWorld& world) { return world.*&SolverOwnership::m_ownsConstraintSolver; }
};

}  // namespace

class Attachment : public btConstraintSolver, public btActionInterface {
 public:
  Attachment(btDiscreteDynamicsWorld& world, Layer& layer)
      : world_(world), layer_(layer), ownsSolver_(SolverOwnership::of(world)) {
    standBefore(world.getConstraintSolver());
    world.addAction(this);
  }
  Attachment(const Attachment&) = delete;
  Attachment& operator=(const Attachment&) = delete;
  ~Attachment() override {
    world_.removeAction(this);
    if (world_.getConstraintSolver() != this) return;
    world_.setConstraintSolver(solver_);
    SolverOwnership::of(world_) = ownsSolver_;
  }

  int solverChanges() const { return solverChanges_; }

  // ---- the solver's place
  void prepareSolve(int bodies, int manifolds) override {
    solver_->prepareSolve(bodies, manifolds);
    called_ = true;
    layer_.forgetRemoved();
    running_ = !layer_.isIdle();
    if (!running_) return;
    const btScalar dt = world_.getSolverInfo().m_timeStep;
    layer_.beginFrame();
    layer_.takeChanges(dt);
    layer_.keepAwake(dt);
    layer_.switchSweepsOff();
    layer_.step(dt);
    layer_.offerMeanMotion(dt);
    layer_.silenceOwnPairs();
  }

  btScalar solveGroup(btCollisionObject** bodies, int bodyCount, btPersistentManifold** manifolds,
                      int manifoldCount, btTypedConstraint** constraints, int constraintCount,
                      const btContactSolverInfo& info, btIDebugDraw* drawer,
                      btDispatcher* dispatcher) override {
    return solver_->solveGroup(bodies, bodyCount, manifolds, manifoldCount, constraints, constraintCount,
                               info, drawer, dispatcher);
  }

  void allSolved(const btContactSolverInfo& info, btIDebugDraw* drawer) override {
    solver_->allSolved(info, drawer);
    if (!running_) return;
    layer_.unsilenceOwnPairs();
    layer_.takeCorrections();
  }

  void reset() override { solver_->reset(); }
  /// Not the inner solver's: whoever asks, casts to that type.
  btConstraintSolverType getSolverType() const override { return BT_SEQUENTIAL_IMPULSE_SOLVER; }

  // ---- the action
  void updateAction(btCollisionWorld*, btScalar dt) override {
    if (!called_) standBeforeNewSolver();
    if (running_) {
      layer_.forgetRemoved();
      layer_.switchSweepsOn();
      layer_.store(dt);
      layer_.tellWhatCame();
    }
    called_ = running_ = false;
  }

  void debugDraw(btIDebugDraw* drawer) override {
    drawSand(*drawer, layer_.system(), layer_.drawnParticleLimit());
  }

 private:
  void standBefore(btConstraintSolver* solver) {
    solver_ = solver;
    SolverOwnership::of(world_) = false;
    world_.setConstraintSolver(this);
  }

  void standBeforeNewSolver() {
    if (world_.getConstraintSolver() == this) return;
    ownsSolver_ = SolverOwnership::of(world_);
    standBefore(world_.getConstraintSolver());
    ++solverChanges_;
  }

  btDiscreteDynamicsWorld& world_;
  Layer& layer_;
  btConstraintSolver* solver_ = nullptr;  // the world's own
  bool ownsSolver_;
  int solverChanges_ = 0;
  bool called_ = false;   // prepareSolve has run in this tick
  bool running_ = false;  // and there was sand
};

}  // namespace detail

namespace {

btDiscreteDynamicsWorld& attachable(btDiscreteDynamicsWorld& world) {
  if (dynamic_cast<GranularDynamicsWorld*>(&world))
    throw std::invalid_argument("GranularLayer: the world is a GranularDynamicsWorld, which has sand itself");
  if (dynamic_cast<detail::Attachment*>(world.getConstraintSolver()))
    throw std::invalid_argument("GranularLayer: the world has a layer already; one is enough");
  return world;
}

}  // namespace

GranularLayer::GranularLayer(btDiscreteDynamicsWorld& world, const LayerDef& def)
    : LayerDoor(std::make_unique<detail::Layer>(attachable(world), def, false)),
      attachment_(std::make_unique<detail::Attachment>(world, *layer_)) {}

GranularLayer::~GranularLayer() {
  layer_->hideGrainsFromQueries();
}

int GranularLayer::solverChanges() const {
  return attachment_->solverChanges();
}

}  // namespace BULLET_BRIDGE_PRECISION
}  // namespace bullet_bridge
