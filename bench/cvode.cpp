#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <Eigen/Cholesky>
#include <memory>
#include <stdexcept>
#include <type_traits>

#include "bench/reference.hpp"
#include "sim/terms/potential.hpp"

#ifndef SUN_COMM_NULL  // before SUNDIALS 7
#define SUN_COMM_NULL nullptr
#endif

namespace ferrule {
namespace {

constexpr double kTolerance = 1e-11;

struct Problem {
  const World& world;
  const State& start;
  const std::function<Pose(double)>& hand;
  bool inertial;
};

// Unknowns of order one: micrometres and milliradians (and their rates).
Pose scale() {
  Pose s;
  s << 1e-6, 1e-6, 1e-6, 1e-3, 1e-3;
  return s;
}

Matrix5 damping(const World& world, const Pose& tip) {
  Matrix5 c = Matrix5::Zero();
  const double length = tip[0] < 0 ? -tip[0] : 0;
  if (!world.laws.drag || length == 0) return c;
  const Vector2d e = eccentricity(tip, 0.5 * length);
  const DragCoefficients k = drag(*world.laws.drag, world.annulus, e.norm(), length);
  const Vector2d n = e.norm() > 0 ? Vector2d(e.normalized()) : Vector2d::UnitX();
  const Eigen::Matrix2d across =
      k.tangential * Eigen::Matrix2d::Identity() + (k.radial - k.tangential) * n * n.transpose();
  const double spread = length / std::sqrt(60.0);
  for (const double arm : {0.5 * length - spread, 0.5 * length + spread}) {
    c.block<2, 2>(1, 1) += 0.5 * across;
    c.block<2, 2>(1, 3) += 0.5 * arm * across;
    c.block<2, 2>(3, 1) += 0.5 * arm * across;
    c.block<2, 2>(3, 3) += 0.5 * arm * arm * across;
  }
  c(0, 0) = k.axial;
  return c;
}

int rates(double t, N_Vector y, N_Vector dy, void* data) {
  const Problem& p = *static_cast<const Problem*>(data);
  const Pose s = scale();
  const Eigen::Map<const Pose> position(N_VGetArrayPointer(y));
  const Pose tip = s.cwiseProduct(position);
  if (!tip.allFinite()) return 1;
  State state = p.start;
  state.tip = tip;
  const Pose gradient =
      Potential(p.world, freeze(p.world, state, p.hand(t), 0), tip).gradient.full();
  Eigen::Map<Pose> moving(N_VGetArrayPointer(dy));
  const Matrix5 c = damping(p.world, tip);
  if (!p.inertial) {
    moving = Pose(-c.llt().solve(gradient)).cwiseQuotient(s);
    return 0;
  }
  const Eigen::Map<const Pose> velocity(N_VGetArrayPointer(y) + 5);
  Eigen::Map<Pose> accelerating(N_VGetArrayPointer(dy) + 5);
  moving = velocity;
  accelerating = Pose(p.world.holder.mass.llt().solve(-gradient - c * s.cwiseProduct(velocity)))
                     .cwiseQuotient(s);
  return 0;
}

void check(int flag, const char* what) {
  if (flag < 0) throw std::runtime_error(std::string("CVODE: ") + what + " failed");
}

std::vector<Pose> trajectory(const World& world, const State& start,
                             const std::function<Pose(double)>& hand,
                             const std::vector<double>& times) {
  Problem problem{world, start, hand, world.dynamics == Dynamics::inertial};
  const sunindextype size = problem.inertial ? 10 : 5;
  SUNContext raw_context = nullptr;
  check(SUNContext_Create(SUN_COMM_NULL, &raw_context), "SUNContext_Create");
  const auto free_context = [](SUNContext c) { SUNContext_Free(&c); };
  const std::unique_ptr<std::remove_pointer_t<SUNContext>, decltype(free_context)> context(
      raw_context, free_context);
  const std::unique_ptr<_generic_N_Vector, decltype(&N_VDestroy)> y(
      N_VNew_Serial(size, context.get()), N_VDestroy);
  Eigen::Map<Eigen::VectorXd> values(N_VGetArrayPointer(y.get()), size);
  values.setZero();
  values.head<5>() = start.tip.cwiseQuotient(scale());
  if (problem.inertial) values.tail<5>() = start.velocity.cwiseQuotient(scale());

  const auto free_cvode = [](void* memory) { CVodeFree(&memory); };
  const std::unique_ptr<void, decltype(free_cvode)> cvode(CVodeCreate(CV_BDF, context.get()),
                                                          free_cvode);
  check(CVodeInit(cvode.get(), rates, 0, y.get()), "CVodeInit");
  check(CVodeSStolerances(cvode.get(), kTolerance, kTolerance), "CVodeSStolerances");
  check(CVodeSetUserData(cvode.get(), &problem), "CVodeSetUserData");
  check(CVodeSetMaxNumSteps(cvode.get(), 5'000'000), "CVodeSetMaxNumSteps");
  const std::unique_ptr<_generic_SUNMatrix, decltype(&SUNMatDestroy)> matrix(
      SUNDenseMatrix(size, size, context.get()), SUNMatDestroy);
  const auto free_solver = [](SUNLinearSolver s) { SUNLinSolFree(s); };
  const std::unique_ptr<_generic_SUNLinearSolver, decltype(free_solver)> solver(
      SUNLinSol_Dense(y.get(), matrix.get(), context.get()), free_solver);
  check(CVodeSetLinearSolver(cvode.get(), solver.get(), matrix.get()), "CVodeSetLinearSolver");

  std::vector<Pose> poses;
  for (const double time : times) {
    double t = 0;
    check(CVodeSetStopTime(cvode.get(), time), "CVodeSetStopTime");
    check(CVode(cvode.get(), time, y.get(), &t, CV_NORMAL), "CVode");
    poses.push_back(scale().cwiseProduct(Pose(values.head<5>())));
  }
  return poses;
}

}  // namespace
}  // namespace ferrule

extern "C" {
extern const ferrule::ReferenceTrajectory ferrule_reference_trajectory;
const ferrule::ReferenceTrajectory ferrule_reference_trajectory = ferrule::trajectory;
}
