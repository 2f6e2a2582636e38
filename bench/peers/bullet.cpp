// Bullet, as its manual advises: nothing smaller than 0.2 units (the world a hundred times larger),
// double precision, small collision margins instead of the 0.04 that are made for metres, more
// solver iterations and short fixed steps for accuracy, no deactivation.
#include <btBulletDynamicsCommon.h>

#include "bench/peers/peg.hpp"

namespace ferrule::peers {
namespace {

constexpr double kLarger = 100;  // lengths
constexpr double kMargin = 1e-3 * kLarger * (kBore - kPeg);

struct BulletSettings {
  int iterations;
  double step;  // [s]
};

btVector3 vector_of(const Vector3d& v, double scale) {
  return {scale * v.x(), scale * v.y(), scale * v.z()};
}
Vector3d vector_of(const btVector3& v, double scale) {
  return scale * Vector3d(v.x(), v.y(), v.z());
}

class Bullet : public Engine {
 public:
  Bullet(int segments, const BulletSettings& settings)
      : settings_(settings),
        dispatcher_(&configuration_),
        world_(&dispatcher_, &broadphase_, &solver_, &configuration_),
        cylinder_({kLarger * 0.5 * kPegLength, kLarger * kPeg, kLarger * kPeg}) {
    world_.setGravity({0, 0, 0});
    btContactSolverInfo& info = world_.getSolverInfo();
    info.m_numIterations = settings.iterations;
    info.m_erp = info.m_erp2 = 0.8;
    info.m_splitImpulse = 0;  // a penetration is corrected by velocity, which lasts
    info.m_linearSlop = 0;
    for (const Box& box : ring(segments)) {
      boxes_.push_back(std::make_unique<btBoxShape>(vector_of(box.half, kLarger)));
      boxes_.back()->setMargin(kMargin);
      btRigidBody::btRigidBodyConstructionInfo about(0, nullptr, boxes_.back().get());
      about.m_startWorldTransform =
          btTransform(btQuaternion(btVector3(1, 0, 0), box.angle), vector_of(box.middle, kLarger));
      about.m_friction = 0;
      walls_.push_back(std::make_unique<btRigidBody>(about));
      world_.addRigidBody(walls_.back().get());
    }
    cylinder_.setMargin(kMargin);
    const double square = kLarger * kLarger;
    btRigidBody::btRigidBodyConstructionInfo about(
        kMass, nullptr, &cylinder_, {square * kSpin, square * kTurn, square * kTurn});
    about.m_friction = 0;
    peg_ = std::make_unique<btRigidBody>(about);
    peg_->setActivationState(DISABLE_DEACTIVATION);
    world_.addRigidBody(peg_.get());
  }
  Bullet(const Bullet&) = delete;
  Bullet& operator=(const Bullet&) = delete;
  ~Bullet() override {
    world_.removeRigidBody(peg_.get());
    for (const auto& wall : walls_) world_.removeRigidBody(wall.get());
  }

  void reset(const Vector3d& at) override {
    peg_->setWorldTransform(btTransform(btQuaternion::getIdentity(), vector_of(at, kLarger)));
    peg_->setInterpolationWorldTransform(peg_->getWorldTransform());
    peg_->setLinearVelocity({0, 0, 0});
    peg_->setAngularVelocity({0, 0, 0});
    peg_->clearForces();
    broadphase_.getOverlappingPairCache()->cleanProxyFromPairs(peg_->getBroadphaseHandle(),
                                                               &dispatcher_);
    solver_.reset();
  }

  void step(const Vector3d& force, const Vector3d& moment) override {
    peg_->applyCentralForce(vector_of(force, kLarger));
    peg_->applyTorque(vector_of(moment, kLarger * kLarger));
    world_.stepSimulation(settings_.step, 0);
  }

  Motion motion() const override {
    const btTransform& at = peg_->getWorldTransform();
    const btQuaternion q = at.getRotation();
    return {vector_of(at.getOrigin(), 1 / kLarger), Quaterniond(q.w(), q.x(), q.y(), q.z()),
            vector_of(peg_->getLinearVelocity(), 1 / kLarger),
            vector_of(peg_->getAngularVelocity(), 1)};
  }

 private:
  BulletSettings settings_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_;
  std::vector<std::unique_ptr<btBoxShape>> boxes_;
  std::vector<std::unique_ptr<btRigidBody>> walls_;
  btCylinderShapeX cylinder_;
  std::unique_ptr<btRigidBody> peg_;
};

std::vector<Peer> bullet_peers() {
  std::vector<Peer> list;
  for (const auto& [segments, settings] : std::vector<std::pair<int, BulletSettings>>{
           {24, {10, 1e-3}}, {24, {50, 1e-3}}, {96, {50, 1e-3}}, {24, {50, 1e-4}}})
    list.push_back({"Bullet", FERRULE_PEER_VERSION,
                    std::to_string(settings.iterations) +
                        " iterations, ERP 0.8, margin 1e-3 of the clearance, world x100",
                    segments, settings.step, [segments = segments, settings = settings] {
                      return std::make_unique<Bullet>(segments, settings);
                    }});
  return list;
}

}  // namespace
}  // namespace ferrule::peers

extern "C" {
extern const ferrule::peers::Peers ferrule_peers_bullet;
const ferrule::peers::Peers ferrule_peers_bullet = ferrule::peers::bullet_peers;
}
