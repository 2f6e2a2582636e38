// ODE, as its manual advises: lengths and masses near 1 ("0.1 to 1.0 is best": the world ten times
// larger still), double precision, dWorldStep where accuracy counts and QuickStep with more
// iterations where speed does, an ERP of up to 0.8, a CFM that is all but hard, no surface layer.
#include <ode/ode.h>

#include "bench/peers/peg.hpp"

namespace ferrule::peers {
namespace {

constexpr double kLarger = 10;  // lengths
constexpr int kContacts = 16;   // of one pair, at most

struct OdeSettings {
  bool quick;
  double step;  // [s]
};

class Ode : public Engine {
 public:
  Ode(int segments, const OdeSettings& settings) : settings_(settings) {
    static const bool started = dInitODE2(0) && dAllocateODEDataForThread(dAllocateMaskAll);
    if (!started) throw std::runtime_error("ODE does not start");
    dSetMessageHandler([](int, const char*, va_list) {});  // of an LCP that is all but singular
    world_ = dWorldCreate();
    space_ = dSimpleSpaceCreate(nullptr);
    contacts_ = dJointGroupCreate(0);
    dWorldSetERP(world_, 0.8);
    dWorldSetCFM(world_, 1e-10);
    dWorldSetContactSurfaceLayer(world_, 0);
    dWorldSetAutoDisableFlag(world_, 0);
    dWorldSetQuickStepNumIterations(world_, 50);
    for (const Box& box : ring(segments)) {
      const Vector3d edges = 2 * kLarger * box.half, middle = kLarger * box.middle;
      dGeomID geom = dCreateBox(space_, edges.x(), edges.y(), edges.z());
      dGeomSetPosition(geom, middle.x(), middle.y(), middle.z());
      dMatrix3 turned;
      dRFromAxisAndAngle(turned, 1, 0, 0, box.angle);
      dGeomSetRotation(geom, turned);
    }
    body_ = dBodyCreate(world_);
    dMass mass;
    const double square = kLarger * kLarger;
    dMassSetParameters(&mass, kMass, 0, 0, 0, square * kSpin, square * kTurn, square * kTurn, 0, 0,
                       0);
    dBodySetMass(body_, &mass);
    peg_ = dCreateCylinder(nullptr, kLarger * kPeg, kLarger * kPegLength);
    dGeomSetBody(peg_, body_);
    dMatrix3 along_x;  // ODE's cylinders lie along z
    dRFromAxisAndAngle(along_x, 0, 1, 0, std::numbers::pi / 2);
    dGeomSetOffsetRotation(peg_, along_x);
  }
  Ode(const Ode&) = delete;
  Ode& operator=(const Ode&) = delete;
  ~Ode() override {
    dJointGroupDestroy(contacts_);
    dGeomDestroy(peg_);
    dSpaceDestroy(space_);
    dWorldDestroy(world_);
  }

  void reset(const Vector3d& at) override {
    const dQuaternion upright = {1, 0, 0, 0};
    dBodySetPosition(body_, kLarger * at.x(), kLarger * at.y(), kLarger * at.z());
    dBodySetQuaternion(body_, upright);
    dBodySetLinearVel(body_, 0, 0, 0);
    dBodySetAngularVel(body_, 0, 0, 0);
  }

  void step(const Vector3d& force, const Vector3d& moment) override {
    const Vector3d f = kLarger * force, m = kLarger * kLarger * moment;
    dBodyAddForce(body_, f.x(), f.y(), f.z());
    dBodyAddTorque(body_, m.x(), m.y(), m.z());
    dSpaceCollide2(peg_, reinterpret_cast<dGeomID>(space_), this, &touch);
    if (settings_.quick)
      dWorldQuickStep(world_, settings_.step);
    else
      dWorldStep(world_, settings_.step);
    dJointGroupEmpty(contacts_);
  }

  Motion motion() const override {
    const dReal *p = dBodyGetPosition(body_), *q = dBodyGetQuaternion(body_),
                *v = dBodyGetLinearVel(body_), *w = dBodyGetAngularVel(body_);
    return {Vector3d(p[0], p[1], p[2]) / kLarger, Quaterniond(q[0], q[1], q[2], q[3]),
            Vector3d(v[0], v[1], v[2]) / kLarger, Vector3d(w[0], w[1], w[2])};
  }

 private:
  static void touch(void* self, dGeomID a, dGeomID b) {
    Ode& ode = *static_cast<Ode*>(self);
    dContact contacts[kContacts];
    const int count = dCollide(a, b, kContacts, &contacts[0].geom, sizeof(dContact));
    for (int i = 0; i < count; ++i) {
      contacts[i].surface.mode = 0;
      contacts[i].surface.mu = 0;
      dJointAttach(dJointCreateContact(ode.world_, ode.contacts_, &contacts[i]), dGeomGetBody(a),
                   dGeomGetBody(b));
    }
  }

  OdeSettings settings_;
  dWorldID world_;
  dSpaceID space_;
  dJointGroupID contacts_;
  dBodyID body_;
  dGeomID peg_;
};

std::vector<Peer> ode_peers() {
  std::vector<Peer> list;
  for (const auto& [segments, settings] :
       std::vector<std::pair<int, OdeSettings>>{{24, {true, 1e-3}},
                                                {96, {true, 1e-3}},
                                                {24, {false, 1e-3}},
                                                {96, {false, 1e-3}},
                                                {96, {false, 1e-4}}})
    list.push_back({"ODE", FERRULE_PEER_VERSION,
                    std::string(settings.quick ? "QuickStep, 50 iterations" : "dWorldStep") +
                        ", ERP 0.8, CFM 1e-10, world x10",
                    segments, settings.step, [segments = segments, settings = settings] {
                      return std::make_unique<Ode>(segments, settings);
                    }});
  return list;
}

}  // namespace
}  // namespace ferrule::peers

extern "C" {
extern const ferrule::peers::Peers ferrule_peers_ode;
const ferrule::peers::Peers ferrule_peers_ode = ferrule::peers::ode_peers;
}
