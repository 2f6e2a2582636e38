// MuJoCo, as its documentation advises: for contacts as hard as they can be a time constant of
// solref of twice the step, and impedances near 1 from the first penetration on; Newton's solver;
// the integrator implicitfast; frictionless contacts (condim 1); shorter steps for accuracy.
#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include "bench/peers/peg.hpp"

namespace ferrule::peers {
namespace {

class MuJoCo : public Engine {
 public:
  MuJoCo(int segments, double step) {
    std::string xml = fmt::format(
        "<mujoco><compiler angle='radian'/><option timestep='{0}' gravity='0 0 0' solver='Newton' "
        "integrator='implicitfast' tolerance='1e-12'/><default><geom condim='1' solref='{1} 1' "
        "solimp='0.99 0.9999 1e-6'/></default><worldbody>",
        step, 2 * step);
    for (const Box& box : ring(segments))
      xml += fmt::format(
          "<geom type='box' size='{:.15g} {:.15g} {:.15g}' pos='{:.15g} {:.15g} {:.15g}' "
          "euler='{:.15g} 0 0'/>",
          box.half.x(), box.half.y(), box.half.z(), box.middle.x(), box.middle.y(), box.middle.z(),
          box.angle);
    // A cylinder lies along its z.
    xml += fmt::format(
        "<body name='peg'><freejoint/><inertial pos='0 0 0' mass='{:.15g}' diaginertia='{:.15g} "
        "{:.15g} {:.15g}'/><geom type='cylinder' size='{:.15g} {:.15g}' euler='0 {:.15g} 0'/>"
        "</body></worldbody></mujoco>",
        kMass, kSpin, kTurn, kTurn, kPeg, 0.5 * kPegLength, std::numbers::pi / 2);
    mjVFS files;
    mj_defaultVFS(&files);
    mj_addBufferVFS(&files, "peg.xml", xml.data(), static_cast<int>(xml.size()));
    char error[500] = "";
    model_ = mj_loadXML("peg.xml", &files, error, sizeof error);
    mj_deleteVFS(&files);
    if (!model_) throw std::runtime_error(std::string("MuJoCo: ") + error);
    data_ = mj_makeData(model_);
  }
  MuJoCo(const MuJoCo&) = delete;
  MuJoCo& operator=(const MuJoCo&) = delete;
  ~MuJoCo() override {
    mj_deleteData(data_);
    mj_deleteModel(model_);
  }

  void reset(const Vector3d& at) override {
    mj_resetData(model_, data_);
    Vector3d::Map(data_->qpos) = at;
    mj_forward(model_, data_);
  }

  void step(const Vector3d& force, const Vector3d& moment) override {
    Vector3d::Map(data_->xfrc_applied + 6) = force;
    Vector3d::Map(data_->xfrc_applied + 9) = moment;
    mj_step(model_, data_);
  }

  Motion motion() const override {
    const mjtNum* q = data_->qpos + 3;
    const Quaterniond turned(q[0], q[1], q[2], q[3]);
    return {Vector3d::Map(data_->qpos), turned, Vector3d::Map(data_->qvel),
            turned * Vector3d(Vector3d::Map(data_->qvel + 3))};
  }

 private:
  mjModel* model_;
  mjData* data_;
};

std::vector<Peer> mujoco_peers() {
  std::vector<Peer> list;
  for (const auto& [segments, step] :
       std::vector<std::pair<int, double>>{{24, 1e-3}, {96, 1e-3}, {24, 1e-4}, {96, 1e-4}})
    list.push_back({"MuJoCo", mj_versionString(),
                    "Newton, implicitfast, solref of 2 steps, solimp 0.99 0.9999 1e-6, condim 1",
                    segments, step, [segments = segments, step = step] {
                      return std::make_unique<MuJoCo>(segments, step);
                    }});
  return list;
}

}  // namespace
}  // namespace ferrule::peers

extern "C" {
extern const ferrule::peers::Peers ferrule_peers_mujoco;
const ferrule::peers::Peers ferrule_peers_mujoco = ferrule::peers::mujoco_peers;
}
